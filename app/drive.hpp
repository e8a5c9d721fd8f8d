#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/data/run.hpp>
#include <chasles/slam/velocity_noise.hpp>
#include <chasles/slam/velocity_settings.hpp>
#include <chasles/slam/velocity_slam.hpp>
#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/smooth/window/window.hpp>

#include "observation_spans.hpp"

namespace chasles::app {

class Interrupt;
class LiveView;

/// A recording after an estimator has gone through it.
struct Drive {
  Run run;
  std::vector<Estimate> estimates;  ///< as they are in `run`
  VelocitySlamNoise noise;
  double time_offset = 0;              ///< by which the velocities' stamps were corrected [s]
  std::unique_ptr<VelocitySlam> slam;  ///< the filter, as it is after the last frame
  ObservationSpans observation_spans;
  bool interrupted = false;            ///< by a signal: `run` ends early
  std::optional<BatchReport> batch;    ///< of batch estimation; run is what it found
  std::optional<WindowReport> window;  ///< where a window went through it
};

/// Gives the velocities the frames' clock, by the offset that is set, or that the tracks tell where
/// it is to be found (a remark says what was). Returns it [s].
double correct_clock(const VelocitySlamSettings& settings, Recording& recording);

/// Runs the filter over the whole recording, or until an interrupt. With `quiet` there is no
/// progress bar. Viewers are shown `velocities_alone` from the beginning.
Drive drive(const Recording& recording, const VelocitySlamSettings& settings,
            const Interrupt& interrupt, bool quiet, Trajectory velocities_alone, LiveView& live);

/// A window of so many keyframes goes through it instead. Throws as VelocityWindow of
/// smooth/velocity_window.hpp.
Drive slide(const Recording& recording, const VelocitySlamSettings& settings,
            const BatchSettings& batch, int keyframes, const Interrupt& interrupt, bool quiet,
            Trajectory velocities_alone, LiveView& live);

/// Batch estimation from the filter's run on, which it replaces. Throws as smooth() of
/// smooth/velocity_batch.hpp.
void smooth(const Recording& recording, const VelocitySlamSettings& settings,
            const BatchSettings& batch, Drive& drive);

/// world_T_imu at every frame from the velocities alone: the pose at the first event is the
/// identity, midpoint rule, exact exponential. Ends where it is no longer finite.
Trajectory dead_reckoning(const Recording& recording);

}  // namespace chasles::app
