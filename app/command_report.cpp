#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/data/run.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>
#include <chasles/report/report.hpp>

#include "subcommands.hpp"

namespace chasles::app {
namespace {

struct ReportOptions {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path output;
  bool quiet = false;
};

// The summary and, where there is one, timing.json: the page shows the speed too.
ReportRun read_with_timing(const std::filesystem::path& folder) {
  nlohmann::ordered_json summary = read_summary(folder);
  const std::filesystem::path file = folder / "timing.json";
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) {
    const auto timing = nlohmann::ordered_json::parse(read_file(file), nullptr, false);
    if (!timing.is_object()) {
      throw InputError(fmt::format("{}: expected a JSON object", file.string()));
    }
    summary.update(timing);
  }
  return {.run = read_run(folder), .summary = summary.dump()};
}

int report(const ReportOptions& o) {
  std::vector<ReportRun> runs;
  for (const std::filesystem::path& folder : o.runs) runs.push_back(read_with_timing(folder));
  if (o.output.has_parent_path()) make_folder(o.output.parent_path());
  write_file(o.output, run_page(runs));
  if (!o.quiet) fmt::print("page: {}\n", o.output.string());
  return 0;
}

}  // namespace

Action declare_report(CLI::App& parser) {
  const auto o = std::make_shared<ReportOptions>();
  parser.add_option("RUN", o->runs, "Run folders, as `chasles run -o` writes them")
      ->required()
      ->type_name("");
  parser.add_option("-o,--output", o->output, "The page")->required()->type_name("FILE.html");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  return [o] { return report(*o); };
}

}  // namespace chasles::app
