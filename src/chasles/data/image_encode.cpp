#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <chasles/data/image_encode.hpp>

namespace chasles {
namespace {

constexpr int kQuality = 50;

}  // namespace

std::string jpeg_bytes(const GrayImage& image, int most_width) {
  if (image.empty()) return {};
  // OpenCV has no view of const bytes; nothing writes to these.
  cv::Mat picture(image.height, image.width, CV_8UC1,
                  const_cast<std::uint8_t*>(image.pixels.data()));
  if (image.width > most_width) {
    const double scale = static_cast<double>(most_width) / image.width;
    const int height = std::max(1, static_cast<int>(std::lround(scale * image.height)));
    cv::Mat smaller;
    cv::resize(picture, smaller, cv::Size(most_width, height), 0, 0, cv::INTER_AREA);
    picture = smaller;
  }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return {bytes.begin(), bytes.end()};
}

}  // namespace chasles
