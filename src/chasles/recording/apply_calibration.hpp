#pragma once

#include <filesystem>

#include <chasles/calibration/imu_intrinsics.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// The range that the recording states; for a sensor without one, shown_range() of its samples.
ImuRange range_of(const Recording& recording);

/// Gives the recording cameras, noise, range and remarks. Time offsets and intrinsics are applied
/// to images and samples by open_cameras() and correct_samples().
void take_kalibr(const KalibrCalibration& calibration, Recording& recording);

/// The same from calibration.yaml, with its name and convention of samples: the first `cameras`
/// cameras. Returns their time offsets. Throws InputError for one without cameras or without an
/// IMU, and as read_calibration().
KalibrCalibration take_own_calibration(const std::filesystem::path& file, std::size_t cameras,
                                       Recording& recording);

/// Makes densities of a noise that is stated for samples, by the interval between the recording's
/// samples, with a remark; nothing for other calibrations. VINS-Mono (Qin, Li and Shen 2018) adds
/// its noise once for each sample: over the interval dt the white noise sigma is a density of
/// sigma sqrt(dt), and the random walk likewise.
void take_noise_of_samples(const KalibrCalibration& calibration, Recording& recording);

/// Corrects the samples of the recording, with a remark. Samples at the limit of the range are
/// marked before (ImuSample::force_clipped): the range is that of the sensor, so it is assessed on
/// what the sensor measured. The recording's range then is one that no other sample reaches.
void correct_samples(const ImuIntrinsics& intrinsics, Recording& recording);

}  // namespace chasles
