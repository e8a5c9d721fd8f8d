#pragma once

#include <string>

#include <chasles/report/report.hpp>

namespace chasles {

/// The run as an MCAP file that Foxglove and Rerun open (docs/formats.md lists the topics): frames
/// world, imu and cam0 …, poses with covariance, the trajectories as lines, the final map as a
/// cloud and as ellipsoids, figures and errors over time, the position on the Earth where known,
/// and the kept images with their features. Messages are Protocol Buffers in Foxglove's schemas,
/// and in Chasles' own schemas for figures. Timing is left out: the same estimates give the same
/// bytes. Poses that are not finite are left out.
///
/// Throws InputError if times are before 1970 or the summary is not a JSON object.
std::string run_mcap(const ReportRun& run, const std::string& version);

}  // namespace chasles
