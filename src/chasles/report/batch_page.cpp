#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include <chasles/report/batch_page.hpp>
#include <chasles/report/encode.hpp>
#include <chasles/report/page_images.hpp>
#include <chasles/report/page_template.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

std::size_t rank_of(const Json& record) {
  constexpr std::array<std::string_view, 2> kWorst = {"no", "check"};
  return static_cast<std::size_t>(
      std::ranges::find(kWorst, record.at("verdict").get<std::string>()) - kWorst.begin());
}

// By verdict, then by the standard deviation; without poses first.
bool is_worse(const BatchRow* a, const BatchRow* b) {
  const auto key = [](const BatchRow& row) {
    const auto sigma = row.record.find("worst_sigma_m");
    const bool known = sigma != row.record.end() && sigma->is_number();
    return std::pair{rank_of(row.record), known ? -sigma->get<double>() : -1e300};
  };
  return key(*a) < key(*b);
}

}  // namespace

std::string batch_page(const Json& summary, std::span<const BatchRow> rows,
                       const Json& difference) {
  std::vector<const BatchRow*> sorted;
  for (const BatchRow& row : rows) sorted.push_back(&row);
  std::ranges::stable_sort(sorted, is_worse);
  Json list = Json::array();
  std::size_t left = kPagePictures;
  for (const BatchRow* row : sorted) {
    Json shown = row->record;
    if (!row->jpeg.empty() && row->jpeg.size() <= left) {
      left -= row->jpeg.size();
      shown["picture"] = base64({row->jpeg.begin(), row->jpeg.end()});
    }
    list.push_back(std::move(shown));
  }
  return with_data(batch_template,
                   {{"summary", summary}, {"recordings", list}, {"difference", difference}});
}

}  // namespace chasles
