#include <fstream>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/error.hpp>
#include <chasles/report/encode.hpp>
#include <chasles/report/page_data.hpp>
#include <chasles/report/page_template.hpp>
#include <chasles/report/report.hpp>

namespace chasles {
namespace {

std::string with_data(const nlohmann::ordered_json& data) {
  static constexpr std::string_view kPlace = "@PAGE_DATA@";
  const std::size_t place = page_template.find(kPlace);
  std::string page(page_template.substr(0, place));
  page += json_for_html(data);
  page += page_template.substr(place + kPlace.size());
  return page;
}

void insert_behind(std::string_view what, std::string_view text, std::string& page) {
  const std::size_t place = page.find(what);
  if (place == std::string::npos) throw std::logic_error("the page is not as live_page() expects");
  page.insert(place + what.size(), text);
}

}  // namespace

std::string run_page(const std::vector<ReportRun>& runs) {
  if (runs.empty()) {
    throw UsageError("a report needs at least one run: name the folder that `chasles run` wrote");
  }
  return with_data(page_data(runs));
}

std::string live_page() {
  std::string page = with_data({{"live", true}});
  insert_behind("default-src 'none';", " connect-src 'self';", page);
  // A browser asks a server for an icon unless it is told that there is none.
  insert_behind("<head>", "<link rel=\"icon\" href=\"data:,\">", page);
  return page;
}

void write_page(const std::vector<ReportRun>& runs, const std::filesystem::path& file) {
  const std::string page = run_page(runs);
  std::error_code ignored;  // What matters is whether the file can be opened.
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  std::ofstream out(file, std::ios::binary);
  out << page;
  out.close();
  if (!out) {
    throw InputError(
        fmt::format("{}: the page cannot be written; is the folder writable, is the "
                    "disk full?",
                    file.string()));
  }
}

}  // namespace chasles
