#include <algorithm>
#include <charconv>
#include <tuple>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/recording/image_names.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

NumberedImage numbered(const std::string& file) {
  NumberedImage image{.file = file, .before = {}, .number = {}, .ordinal = {}};
  const std::string stem = fs::path(file).stem().string();
  std::size_t begin = stem.find_last_not_of("0123456789.");
  begin = begin == std::string::npos ? 0 : begin + 1;
  while (begin < stem.size() && stem[begin] == '.') ++begin;
  image.before = stem.substr(0, begin);
  image.number = stem.substr(begin);
  const char* end = image.number.data() + image.number.size();
  long value = 0;
  const auto [stop, error] = std::from_chars(image.number.data(), end, value);
  if (error == std::errc() && stop == end) image.ordinal = value;
  return image;
}

// Of digits with a point: by their whole part, then by the text.
std::tuple<std::size_t, std::string> order_of(const NumberedImage& image) {
  const std::size_t point = std::min(image.number.find('.'), image.number.size());
  const std::size_t zeros = std::min(image.number.find_first_not_of('0'), point);
  return {point - zeros, image.number.substr(zeros)};
}

}  // namespace

std::vector<NumberedImage> images_in(const fs::path& folder) {
  std::error_code error;
  fs::directory_iterator files(folder, error);
  if (error) {
    throw InputError(
        fmt::format("{}: no such folder, expected the images of a camera there", folder.string()));
  }
  std::vector<NumberedImage> images;
  for (const fs::directory_entry& entry : files) {
    const std::string name = entry.path().filename().string();
    if (is_image_name(name)) images.push_back(numbered(name));
  }
  std::ranges::sort(images, [](const NumberedImage& a, const NumberedImage& b) {
    return std::tuple(a.before, order_of(a), a.file) < std::tuple(b.before, order_of(b), b.file);
  });
  return images;
}

bool are_counted(const std::vector<NumberedImage>& images) {
  constexpr long kStep = 1000;  // between two images, as nanoseconds: no camera has 1 MHz
  if (images.size() < 2) return images.size() == 1 && images[0].ordinal.value_or(kStep) < kStep;
  const auto unknown = [](const NumberedImage& image) { return !image.ordinal; };
  if (std::ranges::any_of(images, unknown)) return false;
  const long first = *images.front().ordinal, last = *images.back().ordinal;
  return (last - first) / kStep < static_cast<long>(images.size()) && last < 1'000'000'000;
}

bool are_numbers(const std::vector<NumberedImage>& images) {
  return std::ranges::all_of(images, [&](const NumberedImage& image) {
    return !image.number.empty() && image.before == images.front().before &&
           std::ranges::count(image.number, '.') <= 1;
  });
}

}  // namespace chasles
