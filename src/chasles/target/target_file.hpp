#pragma once

#include <filesystem>
#include <string>

#include <chasles/target/target.hpp>

namespace chasles {

/// Reads the YAML file of a target, by its `target_type`. Lengths in metres.
///
/// | target_type    | keys                                                          | as          |
/// |----------------|---------------------------------------------------------------|-------------|
/// | `aprilgrid`    | tagCols, tagRows, tagSize, tagSpacing (a part of tagSize); may  | Kalibr | |
/// | have codeOffset                                                | | | `checkerboard` |
/// targetCols, targetRows (inner corners), rowSpacingMeters,     | Kalibr      | |                |
/// colSpacingMeters                                              |             | | `charuco`      |
/// squaresX, squaresY, squareLength, markerLength, dictionary,   | OpenCV's    | |                |
/// legacy_pattern                                                | names       |
///
/// Throws InputError with file, line and key, the value found and the value expected: for a file
/// that cannot be read, other types (circlegrid), unknown or missing keys, and sizes of which no
/// board can be made.
Target read_target(const std::filesystem::path& file);

/// The file that read_target() reads. Throws UsageError as validate().
std::string target_yaml(const Target& target);

/// Writes it. Throws UsageError where that is not possible.
void write_target(const std::filesystem::path& file, const Target& target);

}  // namespace chasles
