#include <cstring>
#include <stdexcept>

#include <chasles/report/testing.hpp>

namespace chasles::test {
namespace {

std::string decoded(const std::string& base64) {
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : base64) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(kDigits.find(c));
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 0xff);
  }
  return bytes;
}

template <typename Number>
std::vector<double> numbers(const std::string& bytes) {
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Number));
  return {values.begin(), values.end()};
}

}  // namespace

nlohmann::json data_of(const std::string& page) {
  const std::string opening = R"(<script type="application/json" id="report-data">)";
  const std::size_t from = page.find(opening) + opening.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script", from) - from));
}

std::vector<double> column(const nlohmann::json& text) {
  const auto whole = text.get<std::string>();
  const std::string kind = whole.substr(0, 4), bytes = decoded(whole.substr(4));
  if (kind == "f32:") return numbers<float>(bytes);
  if (kind == "f64:") return numbers<double>(bytes);
  if (kind == "i32:") return numbers<std::int32_t>(bytes);
  throw std::invalid_argument("unknown column " + kind);
}

}  // namespace chasles::test
