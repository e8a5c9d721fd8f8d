#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/session/report_run.hpp>

namespace chasles {

ReportRun read_with_timing(const std::filesystem::path& folder) {
  Run run = read_run(folder);  // its message is the best one for a wrong folder
  nlohmann::ordered_json summary = read_summary(folder);
  const std::filesystem::path file = folder / "timing.json";
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) {
    summary.update(parse_json_object(read_file(file), file.string()));
  }
  return {.run = std::move(run), .summary = json_text(summary), .label = folder_name(folder)};
}

}  // namespace chasles
