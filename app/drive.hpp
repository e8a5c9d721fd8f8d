#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/data/run.hpp>
#include <chasles/slam/noise.hpp>
#include <chasles/slam/settings.hpp>
#include <chasles/slam/slam.hpp>
#include <chasles/smooth/drive_batch.hpp>
#include <chasles/smooth/window.hpp>

#include "sightings.hpp"

namespace chasles::app {

class Interrupt;
class LiveView;

/// A recording after an estimator has gone through it.
struct Drive {
  Run run;
  std::vector<Estimate> estimates;  ///< as they are in `run`
  Noise noise;
  double time_offset = 0;      ///< by which the velocities' stamps were corrected [s]
  std::unique_ptr<Slam> slam;  ///< the filter, as it is after the last frame
  Sightings sightings;
  bool interrupted = false;            ///< by a signal: `run` ends early
  std::optional<BatchReport> batch;    ///< of batch estimation; run is what it found
  std::optional<WindowReport> window;  ///< where a window went through it
};

/// Gives the velocities the frames' clock, by the offset that is set, or that the tracks tell where
/// it is to be found (a remark says what was). Returns it [s].
double correct_clock(const Settings& settings, Recording& recording);

/// Runs the filter over the whole recording, or until an interrupt. With `quiet` there is no
/// progress bar. Viewers are shown `velocities_alone` from the beginning.
Drive drive(const Recording& recording, const Settings& settings, const Interrupt& interrupt,
            bool quiet, Trajectory velocities_alone, LiveView& live);

/// A window of so many keyframes goes through it instead. Throws as DriveWindow of
/// smooth/drive_window.hpp.
Drive slide(const Recording& recording, const Settings& settings, const BatchSettings& batch,
            int keyframes, const Interrupt& interrupt, bool quiet, Trajectory velocities_alone,
            LiveView& live);

/// Batch estimation from the filter's run on, which it replaces. Throws as smooth() of
/// smooth/drive_batch.hpp.
void smooth(const Recording& recording, const Settings& settings, const BatchSettings& batch,
            Drive& drive);

/// world_T_imu at every frame from the velocities alone: the pose at the first event is the
/// identity, midpoint rule, exact exponential. Ends where it is no longer finite.
Trajectory dead_reckoning(const Recording& recording);

}  // namespace chasles::app
