#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// An image file of a camera, with the number that its name ends with.
struct NumberedImage {
  std::string file;             ///< "frame_0012.png"
  std::string before;           ///< "frame_"
  std::string number;           ///< "0012", "1403636584.763556"; empty without one
  std::optional<long> ordinal;  ///< 12; none for decimals and large numbers
};

/// The images in a folder, in the order of their numbers and then of their names. Hidden files are
/// left out. Throws InputError without the folder.
std::vector<NumberedImage> images_in(const std::filesystem::path& folder);

/// Whether the names of the images count them: whole numbers, fewer than one in 1000 ns.
bool are_counted(const std::vector<NumberedImage>& images);

/// Whether all names are a number, with the same text before it.
bool are_numbers(const std::vector<NumberedImage>& images);

}  // namespace chasles
