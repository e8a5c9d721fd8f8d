#include <cstring>
#include <stdexcept>
#include <zlib.h>

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
std::vector<double> numbers(const std::string& planes) {
  const std::size_t n = planes.size() / sizeof(Number);
  std::string bytes;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    bytes += planes[i % sizeof(Number) * n + i / sizeof(Number)];
  }
  std::vector<Number> values(n);
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return {values.begin(), values.end()};
}

}  // namespace

nlohmann::json data_of(const std::string& page) {
  const std::string opening = R"(<script type="application/json" id="report-data">)";
  const std::size_t from = page.find(opening) + opening.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script", from) - from));
}

std::string planes_of(const std::string& column) {
  const std::string packed = decoded(column.substr(4));
  std::string bytes(64, '\0');
  for (;; bytes.resize(2 * bytes.size())) {
    uLongf size = bytes.size();
    const int result = uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                                  reinterpret_cast<const Bytef*>(packed.data()), packed.size());
    if (result == Z_OK) return bytes.substr(0, size);
    if (result != Z_BUF_ERROR) throw std::invalid_argument("not a zlib stream");
  }
}

std::vector<double> column(const nlohmann::json& text) {
  const auto whole = text.get<std::string>();
  const std::string kind = whole.substr(0, 4), bytes = planes_of(whole);
  if (kind == "f32:") return numbers<float>(bytes);
  if (kind == "f64:") return numbers<double>(bytes);
  if (kind == "i32:") return numbers<std::int32_t>(bytes);
  throw std::invalid_argument("unknown column " + kind);
}

}  // namespace chasles::test
