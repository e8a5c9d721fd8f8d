#pragma once

#include <functional>
#include <vector>

#include <chasles/filter/covariance.hpp>
#include <chasles/filter/past/history.hpp>

/// Estimates from the steps of a History: a sweep backwards in time, and one forwards. Private to
/// this folder.
namespace chasles::filter_detail {

/// What the sweep forwards is read for. Any function may be null.
struct HistoryReader {
  /// Called at each removal, before the rows are removed: mean and covariance of the errors d,
  /// given all measurements.
  std::function<void(const History::Removal&, const Eigen::VectorXd& d, Covariance::ConstBlock& P)>
      landmarks;
  History::RowVisitor covariance;  ///< as History::visit_covariance()
  /// Called at each remembered pose, likewise.
  std::function<void(const History::Pose&, const Eigen::VectorXd& d, Covariance::ConstBlock& P)>
      poses = nullptr;
};

/// `core`: rows of the core; `initial`: covariance of d before the first step; `size_now`: rows of
/// d after the last.
void read(int core, const Eigen::MatrixXd& initial, const std::vector<History::Step>& steps,
          Eigen::Index size_now, const HistoryReader& reader);

}  // namespace chasles::filter_detail
