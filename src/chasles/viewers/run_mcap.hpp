#pragma once

#include <string>

#include <chasles/report/report.hpp>

namespace chasles {

/// The run as an MCAP file that Foxglove and Rerun open (docs/formats.md lists the topics): frames
/// world, imu and cam0 …, poses with covariance, the ways as lines, the final map as a cloud and as
/// ellipsoids, figures and errors over time, the place on the Earth where it is known, and the
/// images that were kept, with what was seen in them. Messages are Protocol Buffers of Foxglove's
/// schemas, and of the house's own for figures. Timing is left out: the same estimates give the
/// same bytes. Poses that are not finite are left out.
///
/// Throws InputError where times are before 1970 or the summary is not a json object.
std::string run_mcap(const ReportRun& run, const std::string& version);

}  // namespace chasles
