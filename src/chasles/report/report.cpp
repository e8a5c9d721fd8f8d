#include <stdexcept>

#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/report/encode.hpp>
#include <chasles/report/page_data.hpp>
#include <chasles/report/page_template.hpp>
#include <chasles/report/report.hpp>

namespace chasles {
namespace {

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
  return with_data(page_template, page_data(runs));
}

std::string map_page(const ReportRun& map) {
  if (!map.run.prior_map) throw UsageError("a page of a map needs a map");
  return with_data(map_template, page_data({map}));
}

std::string live_page() {
  std::string page = with_data(page_template, {{"live", true}});
  insert_behind("default-src 'none';", " connect-src 'self';", page);
  // A browser requests an icon from the server unless the page states that there is none.
  insert_behind("<head>", "<link rel=\"icon\" href=\"data:,\">", page);
  return page;
}

}  // namespace chasles
