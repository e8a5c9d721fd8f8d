#pragma once

#include <optional>
#include <utility>

#include <chasles/eval/truth_examination.hpp>
#include <chasles/eval/truth_path.hpp>
#include <chasles/eval/truth_reading.hpp>
#include <chasles/eval/truth_sentences.hpp>

// The parts of examine_truth().
namespace chasles {

/// An examination in progress. What is found is applied, so that the parts that follow see the rest
/// alone.
struct TruthWork {
  const TruthReference& reference;
  const Trajectory& truth;
  TruthExaminationOptions options;
  Time gap = kLongestTruthGap;
  Trajectory mended;    ///< the truth in the reading, frame and unit that were found
  Trajectory estimate;  ///< the reference at the point on the body whose positions the truth has
  std::optional<TurningExplanation> turning = {};
  std::optional<BodyFrame> frame = {};   ///< none: the IMU's, as far as it is known
  std::optional<PositionFit> path = {};  ///< with a free scale
  TruthExamination result = {};

  double offset() const { return result.clock ? result.clock->offset : 0; }
  void find(TruthFinding finding) { result.findings.push_back(std::move(finding)); }
};

/// Where no rotation determines it, the positions give the clock: of several shifts that fit alike
/// the one near zero, or none.
void clock_by_positions(TruthWork& work);

/// What is left of the attitudes without the offset and with it [rad].
BeforeAndAfter attitudes_by_clock(const TruthWork& work, double offset);

/// The findings on the clock; on stamps too far apart, where nothing lies between; on the
/// interpolation of what is compared as it is.
void examine_clock(TruthWork& work);
void examine_spacing(TruthWork& work);
void examine_interpolation(TruthWork& work);

/// Mirrored, of another unit, of another path, of one point: with findings, and applied.
void examine_path(TruthWork& work);

/// The point on the body whose positions the truth has, if it is clearly another one. In metres.
std::optional<PositionFit> other_point(const TruthWork& work);

/// The frame of the attitudes by the rates; then, where those leave it open, by the positions. The
/// axes are turned to the IMU's at once, and the positions moved when their unit is known.
void frame_by_rates(TruthWork& work);
void frame_by_positions(TruthWork& work);

/// Moves positions, which are in metres by now, from a known frame to the IMU.
void move_from_known_frame(TruthWork& work);

/// The findings on frame and point.
void report_frame(TruthWork& work);

}  // namespace chasles
