#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// The pose of a path at each frame of the recording, by the frames' stamps; none at a frame
/// without a pose, with one that is not finite, or where the run was lost. A state belongs to the
/// nearest frame within half of the median interval, by the cameras' clock: its time less the
/// time offset, which is estimated (`time_offset` in states.csv) or a setting of the summary.
/// `stamps` rise strictly. Throws InputError as path_poses(), and if no frame has a pose: they are
/// those of another recording.
std::vector<std::optional<SmoothedPose>> poses_at_frames(const ReportRun& run, RunPath path,
                                                         std::span<const Time> stamps);

}  // namespace chasles
