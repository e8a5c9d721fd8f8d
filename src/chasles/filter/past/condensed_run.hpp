#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/past/disk_matrix.hpp>
#include <chasles/filter/past/fixed_interval.hpp>
#include <chasles/filter/past/segment.hpp>

namespace chasles {

/// Fixed-interval smoothing of states that never return, in little memory. Once the state has been
/// exchanged, few directions x connect it with what left before: an item's error is U x + e, with
/// an e that no later measurement concerns. So segments are kept in batches; two batches later, of
/// each item only U, its correction and its covariance remain (docs/map.md). To rounding, nothing
/// is approximate. These are read only when the estimates are asked for: beyond some bound they are
/// on disk, unless that has no room.
class CondensedRun {
 public:
  static constexpr std::size_t kBytesInMemory = 8 << 20;

  /// `segments`: in a batch; `bytes_in_memory`: of condensed batches, others are on disk.
  explicit CondensedRun(int segments, std::size_t bytes_in_memory = kBytesInMemory)
      : segments_(segments), bytes_in_memory_(bytes_in_memory) {}

  /// `end`: covariance of the state at the end of the segment.
  void append(Segment segment, const Eigen::MatrixXd& end);

  /// Correction and covariance of every item, given the measurements of all segments and of the
  /// latest, in the order of numbers.
  using Visitor = std::function<void(const SmoothedState&)>;
  void visit(const Segment& latest, const Visitor& visit) const;

  /// Those of the older half of the condensed batches, given all segments so far. They are given
  /// up.
  void give_up_older_half(const Visitor& visit);

  std::size_t bytes() const;          ///< in memory and on disk
  std::size_t bytes_on_disk() const;  ///< of these

 private:
  /// A segment, without the cross-covariances of its items.
  struct Step {
    Eigen::Index starts = 0;
    std::vector<Segment::Item> items;
    Eigen::MatrixXd X, G_starts;
    Eigen::MatrixXd own;  ///< rows of the items: their covariances, six columns
    Eigen::VectorXd g;
  };
  /// What later measurements do to errors with the cross-covariance C with the state: correction
  /// C g, change of the covariance C G C^T.
  struct Later {
    Eigen::MatrixXd G;
    Eigen::VectorXd g;
  };
  struct Batch {
    std::vector<std::shared_ptr<const Step>> steps;
    Eigen::MatrixXd X;  ///< of its end, by its start
    Later later;        ///< what its measurements do to errors at its start
    Eigen::MatrixXd end;
  };
  /// Of the items of a step: rows [U, correction, covariance].
  struct Rows {
    std::vector<Segment::Item> items;
    Eigen::MatrixXd rows;  ///< empty if they are on disk
    std::optional<DiskMatrix> disk = {};
  };
  /// A batch whose items are known by x: with what the batch after it did to the x before.
  struct Condensed {
    std::vector<std::shared_ptr<const Rows>> steps;  ///< the last first
    Later near;                                      ///< change of the x before
    Eigen::MatrixXd by_next;                         ///< U of the x before, by this one's x
  };
  /// The batch that is being condensed, one step for each that is appended.
  struct Work {
    Batch batch;        ///< its steps are those that are left
    Later later;        ///< from the last of these on, to the end of the next batch
    Eigen::MatrixXd V;  ///< U of errors C there: C V
    Eigen::MatrixXd K;  ///< cross-covariance of x with the state at the end of the next batch
  };

  static Step step_of(Segment segment);
  static void add_to(Batch& batch, Step step);
  static void go_back(const Step& step, Later& later);
  static SmoothedState smoothed(const Step& step, std::size_t item, Eigen::Index row,
                                const Later& later);
  static void prepend(const Step& step, const Later& later, std::vector<SmoothedState>& states);
  static void visit_rows(const Rows& step, const Later& later, const Visitor& visit);
  static void visit_batch(const Condensed& batch, const Later& later, const Visitor& visit);
  void finish(Condensed& batch, const Later& near, const Eigen::MatrixXd& Q) const;
  void condense_step();
  void begin_work(Batch batch);
  Later recent(const Segment* latest, std::vector<SmoothedState>& states) const;
  std::vector<Later> laters(const Later& last) const;

  int segments_;
  std::size_t bytes_in_memory_;
  std::shared_ptr<DiskMatrices> disk_ = std::make_shared<DiskMatrices>();  ///< shared with copies
  std::vector<Condensed> condensed_;  ///< the last of them may be in work
  std::optional<Work> work_;
  std::optional<Batch> after_;  ///< the batch after that in work
  Batch current_;
};

}  // namespace chasles
