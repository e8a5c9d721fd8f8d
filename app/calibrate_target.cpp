#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/target/target_file.hpp>
#include <chasles/target/target_print.hpp>

#include "calibrate_commands.hpp"
#include "options.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

struct TargetOptions {
  std::string kind = std::string(name_of(TargetKind::april_grid));
  int columns = 6, rows = 6;
  std::optional<double> size, spacing, marker;
  std::optional<std::string> dictionary;
  bool legacy_pattern = false;
  std::string paper = "auto";
  std::filesystem::path output;
};

void reject_foreign(bool given, const char* option, TargetKind kind, TargetKind of) {
  if (!given || kind == of) return;
  throw UsageError(
      fmt::format("{} is for --kind {}, found --kind {}", option, name_of(of), name_of(kind)));
}

Target target_of(const TargetOptions& o) {
  const auto kind = choice_of<TargetKind>(o.kind);
  if (!kind) {
    reject_value("--kind", quoted_text(o.kind), one_of_text(kChoiceNames<TargetKind>));
  }
  reject_foreign(o.spacing.has_value(), "--spacing", *kind, TargetKind::april_grid);
  reject_foreign(o.marker.has_value(), "--marker", *kind, TargetKind::charuco);
  reject_foreign(o.dictionary.has_value(), "--dictionary", *kind, TargetKind::charuco);
  reject_foreign(o.legacy_pattern, "--legacy-pattern", *kind, TargetKind::charuco);
  Target target{.kind = *kind, .columns = o.columns, .rows = o.rows};
  if (*kind == TargetKind::april_grid) {
    target.tag_size = *o.size;
    target.tag_spacing = o.spacing.value_or(0.3);
    return target;
  }
  target.column_spacing = target.row_spacing = *o.size;
  if (*kind == TargetKind::charuco) {
    target.tag_size = o.marker.value_or(0.75 * *o.size);
    target.dictionary = o.dictionary.value_or("DICT_5X5_1000");
    target.legacy_pattern = o.legacy_pattern;
  }
  return target;
}

// A file that was corrected by what the print measures must not be lost.
void check_replaceable(const std::filesystem::path& yaml, const Target& target) {
  if (!std::filesystem::exists(yaml) || read_target(yaml) == target) return;
  throw UsageError(fmt::format(
      "{}: is there with other numbers, expected none or the same: choose another -o, or remove it",
      yaml.string()));
}

int write_board(const TargetOptions& o) {
  const Target target = target_of(o);
  const std::string ending = lower_case(o.output.extension().string());
  if (ending != ".pdf" && ending != ".svg") {
    throw UsageError(fmt::format("-o {}: found the ending '{}', expected .pdf or .svg",
                                 o.output.string(), ending));
  }
  const Sheet sheet = sheet_for(target, o.paper);
  const std::filesystem::path yaml = std::filesystem::path(o.output).replace_extension(".yaml");
  check_replaceable(yaml, target);
  if (o.output.has_parent_path()) make_folder(o.output.parent_path());
  const std::string name = yaml.filename().string();
  replace_file(o.output, ending == ".pdf" ? target_pdf(target, sheet, name)
                                          : target_svg(target, sheet, name));
  replace_file(yaml, target_yaml(target));
  app::print("{}: {:.0f} x {:.0f} mm. Print without scaling, measure, and correct {}\n",
             o.output.string(), sheet.width, sheet.height, yaml.string());
  if (target.is_symmetric()) {
    app::print(
        "remark: columns + rows is even, so the board has no upper side of its own: several "
        "cameras need an odd sum\n");
  }
  return 0;
}

}  // namespace

Action declare_calibrate_target(CLI::App& parser) {
  const auto o = std::make_shared<TargetOptions>();
  parser.add_option("--kind", o->kind, "aprilgrid (default), checkerboard or charuco")
      ->type_name(fmt::format("{}", fmt::join(kChoiceNames<TargetKind>, "|")));
  parser
      .add_option("--columns", o->columns,
                  "Tags, inner corners of a checkerboard, or squares of ChArUco (default: 6)")
      ->type_name("N");
  parser.add_option("--rows", o->rows, "The same (default: 6)")->type_name("N");
  add_number(parser, "--size", o->size, "M", "Side of a tag or of a square", 0)->required();
  add_number(parser, "--spacing", o->spacing, "PART",
             "aprilgrid: gap between two tags, as a part of their size (default: 0.3)", 0);
  add_number(parser, "--marker", o->marker, "M",
             "charuco: side of a marker (default: 0.75 of the square)", 0);
  parser
      .add_option("--dictionary", o->dictionary,
                  "charuco: OpenCV's name of the markers (default: DICT_5X5_1000)")
      ->type_name("DICT");
  parser.add_flag("--legacy-pattern", o->legacy_pattern,
                  "charuco: the upper left square is white where the rows are even, as OpenCV "
                  "before 4.6 has it");
  parser.add_option("--paper", o->paper, "Sheet (default: auto, as large as the board)")
      ->type_name(fmt::format("{}", fmt::join(sheet_names(), "|")));
  parser
      .add_option("-o,--output", o->output,
                  "The board, FILE.pdf or FILE.svg. FILE.yaml beside it describes the board")
      ->required()
      ->type_name("FILE");
  return [o] { return write_board(*o); };
}

}  // namespace chasles::app
