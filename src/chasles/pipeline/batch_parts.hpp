#pragma once

#include <span>
#include <vector>

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>

namespace chasles {

/// The events of a recording with an IMU, and the filter's estimates for them.
struct BatchMaterial {
  std::vector<ImuSample> samples;  ///< that are measurements (SampleScreen)
  std::vector<FeatureFrame> frames;
  std::vector<Estimate> estimates;
  std::vector<InertialStart> starts = {};  ///< at which the filter began
};

/// Batch estimation that starts at the filter's first estimate. Where samples are missing for more
/// than InertialSession::kLongestGap, a part ends, because the motion in between is unknown. The
/// parts are estimated separately, each from the filter's first estimate in it. A part that fails
/// keeps the filter's estimates (BatchReport::parts_failed).
///
/// Position and heading of a later part have the uncertainty of its start, to which no measurement
/// of the part contributes.
///
/// There must be an estimate. Throws as smooth() where all parts fail, and BatchStopped.
InertialBatchResult smooth_parts(const InertialSensors& sensors,
                                 const InertialRunSettings& settings, BatchMaterial material,
                                 const StopRequest& stop);

}  // namespace chasles
