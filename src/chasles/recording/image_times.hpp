#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/recording/image_files.hpp>

namespace chasles {

/// Where the images of a camera and the list of their times may be.
struct CameraPlace {
  std::filesystem::path images;  ///< the folder of the image files
  std::string name;              ///< of the camera, as cam0
  /// Where a list of the times of all cameras may be, as times.txt beside image_0 and image_1.
  std::vector<std::filesystem::path> shared = {};
};

/// The images of a camera with their times. The first of these that has them counts:
///
/// 1. times.csv in the folder;
/// 2. the names, in nanoseconds (1403636584763555584.png) or in seconds with decimals;
/// 3. a list in the folder (times.txt, timestamps.txt, …), beside it with the camera's name
///    (cam0_times.txt, …), or in one of the `shared` folders.
///
/// Nothing without the folder. Throws InputError for numbered images (000000.png) without a list,
/// and for a list that does not fit the images.
std::optional<CameraFiles> list_camera_images(const CameraPlace& place,
                                              std::vector<std::string>& remarks);

/// The images of a list: a table with a column of times and, optionally, one of file names (with
/// or without their ending) or of the numbers of the images, with or without a line of names. A
/// list of times alone is for the images in order, or by their numbers. `place.images` is the
/// folder that the names are seen from. Throws InputError for a list that does not fit the images.
CameraFiles read_image_list(const std::filesystem::path& list, const CameraPlace& place,
                            std::vector<std::string>& remarks);

/// The times of a list without its names: of any pictures in order.
std::vector<Time> read_time_list(const std::filesystem::path& list,
                                 std::vector<std::string>& remarks);

/// Takes whole numbers without a unit for micro- or milliseconds where they are within the samples
/// as such, and as nanoseconds none is; with a remark. For all cameras alike.
void fit_units(std::vector<std::optional<CameraFiles>>& cameras, const std::vector<ImuSample>& imu,
               std::vector<std::string>& remarks);

}  // namespace chasles
