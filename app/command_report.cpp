#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/report/report.hpp>
#include <chasles/report/study.hpp>
#include <chasles/session/report_run.hpp>

#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

struct ReportOptions {
  std::vector<std::filesystem::path> folders;  ///< of runs or of studies
  std::filesystem::path output;
  bool quiet = false;
};

std::string page_of_runs(const std::vector<std::filesystem::path>& folders) {
  std::vector<ReportRun> runs;
  for (const std::filesystem::path& folder : folders) runs.push_back(read_with_timing(folder));
  return run_page(runs);
}

std::string page_of_studies(const std::vector<std::filesystem::path>& folders) {
  std::vector<Study> studies;
  for (const std::filesystem::path& folder : folders) studies.push_back(read_study(folder));
  return study_page(studies);
}

// The content of the folders determines their kind. All must be of the same kind.
std::string page_of(const std::vector<std::filesystem::path>& folders) {
  const bool studies = is_study(folders.front());
  for (const std::filesystem::path& folder : folders) {
    if (is_study(folder) == studies) continue;
    throw UsageError(fmt::format("{} is {} and {} is {}: a page shows runs or studies",
                                 folders.front().string(), studies ? "a study" : "a run",
                                 folder.string(), studies ? "none" : "a study"));
  }
  return studies ? page_of_studies(folders) : page_of_runs(folders);
}

int report(const ReportOptions& o) {
  const std::string page = page_of(o.folders);
  if (o.output.has_parent_path()) make_folder(o.output.parent_path());
  replace_file(o.output, page);
  if (!o.quiet) app::print("page: {}\n", o.output.string());
  return 0;
}

}  // namespace

Action declare_report(CLI::App& parser) {
  const auto o = std::make_shared<ReportOptions>();
  parser
      .add_option("RUN|STUDY", o->folders,
                  "Run folders, as `chasles run -o` writes them, or studies, as `chasles compare "
                  "-o` and `chasles montecarlo -o` do")
      ->required()
      ->type_name("");
  parser.add_option("-o,--output", o->output, "The page")->required()->type_name("FILE.html");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  return [o] { return report(*o); };
}

}  // namespace chasles::app
