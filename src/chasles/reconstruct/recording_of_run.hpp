#pragma once

#include <string>
#include <vector>

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// The numbers of the run's cameras in the calibration, from its summary.json. Throws InputError
/// for a run without cameras, or of which the summary does not have them.
std::vector<std::size_t> cameras_of_run(const std::string& summary);

/// A recording as a run of it had it: with the run's cameras at the imu_T_cam of its summary.json,
/// the readout of its settings, and the samples in the axes that the tracks show
/// (examine_tracks()). The part of the recording that the run has left out stays. Throws InputError
/// for another recording's cameras.
Recording as_in_run(Recording recording, const std::string& summary,
                    const InertialRunSettings& settings);

}  // namespace chasles
