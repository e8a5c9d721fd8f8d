#pragma once

#include <string>
#include <vector>

#include <chasles/target/target.hpp>

namespace chasles {

/// A sheet of paper [mm].
struct Sheet {
  double width = 0, height = 0;
};

/// Names of sheets: A0 to A4, letter, and auto.
std::vector<std::string> sheet_names();

/// The sheet of that name, lying or standing as the target fits; for auto one just as large as the
/// target with its margins. Throws UsageError for an unknown name, and for a sheet on which the
/// target does not fit: with the sizes, and the sheets on which it does.
Sheet sheet_for(const Target& target, const std::string& name);

/// The target as a drawing in its true size, with a ruler of 100 mm and its numbers as a text
/// below. `file` is the name of its YAML file, for that text. Throws UsageError as sheet_for() for
/// a sheet that is too small, and as validate().
std::string target_svg(const Target& target, const Sheet& sheet, const std::string& file);
std::string target_pdf(const Target& target, const Sheet& sheet, const std::string& file);

}  // namespace chasles
