#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>
#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target_file.hpp>

namespace chasles {
namespace {

constexpr const char* kTypes = "'aprilgrid', 'checkerboard' or 'charuco'";

YamlMap::Keys all_of(std::vector<std::string> keys) { return {.known = keys, .needed = keys}; }

int whole(const YamlMap& map, const std::string& key, const char* what) {
  const double value = map.number(key);
  if (value == std::floor(value) && value >= 1 && value <= 1000) return static_cast<int>(value);
  throw InputError(fmt::format("{}: is {}, expected the number of {}: a whole number above 0",
                               map.where(key), value, what));
}

int code_offset(const YamlMap& map) {
  const double value = map.number("codeOffset");
  if (value == std::floor(value) && value >= 0 && value <= 1000) return static_cast<int>(value);
  throw InputError(fmt::format("{}: is {}, expected the number of the first tag, a whole number",
                               map.where("codeOffset"), value));
}

Target read_april_grid(const std::filesystem::path& file) {
  YamlMap::Keys keys = all_of({"target_type", "tagCols", "tagRows", "tagSize", "tagSpacing"});
  keys.known.emplace_back("codeOffset");
  const YamlMap map = YamlMap::read(file, keys);
  const Target target{.kind = TargetKind::april_grid,
                      .columns = whole(map, "tagCols", "tags"),
                      .rows = whole(map, "tagRows", "tags"),
                      .tag_size = map.positive("tagSize"),
                      .tag_spacing = map.positive("tagSpacing"),
                      .code_offset = map.has("codeOffset") ? code_offset(map) : 0};
  if (target.tag_spacing < 0.05) {  // Kalibr's most frequent mistake: metres
    throw InputError(fmt::format(
        "{}: is {}, expected the gap between two tags divided by tagSize (0.3 on Kalibr's boards); "
        "if the gap is {} m, write {:.3g}",
        map.where("tagSpacing"), target.tag_spacing, target.tag_spacing,
        target.tag_spacing / target.tag_size));
  }
  return target;
}

Target read_checkerboard(const std::filesystem::path& file) {
  const YamlMap map = YamlMap::read(file, all_of({"target_type", "targetCols", "targetRows",
                                                  "rowSpacingMeters", "colSpacingMeters"}));
  return {.kind = TargetKind::checkerboard,
          .columns = whole(map, "targetCols", "inner corners"),
          .rows = whole(map, "targetRows", "inner corners"),
          .column_spacing = map.positive("colSpacingMeters"),
          .row_spacing = map.positive("rowSpacingMeters")};
}

Target read_charuco(const std::filesystem::path& file) {
  const YamlMap map =
      YamlMap::read(file, all_of({"target_type", "squaresX", "squaresY", "squareLength",
                                  "markerLength", "dictionary", "legacy_pattern"}));
  const double square = map.positive("squareLength");
  return {.kind = TargetKind::charuco,
          .columns = whole(map, "squaresX", "squares"),
          .rows = whole(map, "squaresY", "squares"),
          .tag_size = map.positive("markerLength"),
          .column_spacing = square,
          .row_spacing = square,
          .dictionary = map.text("dictionary"),
          .legacy_pattern =
              map.flag("legacy_pattern", "the upper left square is white where squaresY is even")};
}

Target read_kind(const std::filesystem::path& file) {
  const YamlMap map = YamlMap::read(file, {.known = {}, .needed = {"target_type"}});
  const std::string type = map.text("target_type");
  const auto kind = choice_of<TargetKind>(type);
  if (kind == TargetKind::april_grid) return read_april_grid(file);
  if (kind == TargetKind::checkerboard) return read_checkerboard(file);
  if (kind == TargetKind::charuco) return read_charuco(file);
  const std::string remark =
      type == "circlegrid" ? ". The centre of a circle's image is not the image of its centre, so "
                             "grids of circles are not read"
                           : "";
  throw InputError(
      fmt::format("{}: is '{}', expected {}{}", map.where("target_type"), type, kTypes, remark));
}

}  // namespace

Target read_target(const std::filesystem::path& file) {
  const Target target = read_kind(file);
  try {
    validate(target);
  } catch (const UsageError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
  return target;
}

std::string target_yaml(const Target& target) {
  validate(target);
  if (target.kind == TargetKind::april_grid) {
    return fmt::format(
        "target_type: 'aprilgrid'\n"
        "tagCols: {}        # tags\n"
        "tagRows: {}\n"
        "tagSize: {}    # side of a tag with its black border [m]: measure it on the print\n"
        "tagSpacing: {}   # gap between two tags, divided by tagSize\n{}",
        target.columns, target.rows, target.tag_size, target.tag_spacing,
        target.code_offset == 0
            ? ""
            : fmt::format("codeOffset: {}   # number of the first tag\n", target.code_offset));
  }
  if (target.kind == TargetKind::checkerboard) {
    return fmt::format(
        "target_type: 'checkerboard'\n"
        "targetCols: {}   # inner corners\n"
        "targetRows: {}\n"
        "rowSpacingMeters: {}   # side of a square [m]: measure it on the print\n"
        "colSpacingMeters: {}\n",
        target.columns, target.rows, target.row_spacing, target.column_spacing);
  }
  return fmt::format(
      "target_type: 'charuco'\n"
      "squaresX: {}   # squares\n"
      "squaresY: {}\n"
      "squareLength: {}   # side of a square [m]: measure it on the print\n"
      "markerLength: {}   # side of a marker with its black border [m]\n"
      "dictionary: {}\n"
      "legacy_pattern: {}   # as OpenCV's setLegacyPattern\n",
      target.columns, target.rows, target.column_spacing, target.tag_size, target.dictionary,
      target.legacy_pattern);
}

void write_target(const std::filesystem::path& file, const Target& target) {
  write_file(file, target_yaml(target));
}

}  // namespace chasles
