#include <algorithm>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <chasles/error.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {
namespace {

constexpr int kPad = PyramidLevel::kPad;

void resize(PyramidLevel& level, int width, int height) {
  level.width = width;
  level.height = height;
  level.padded.resize(static_cast<std::size_t>(level.stride()) *
                      static_cast<std::size_t>(height + 2 * kPad));
}

cv::Mat with_padding(PyramidLevel& level) {
  return {level.height + 2 * kPad, level.stride(), CV_8UC1, level.padded.data()};
}

cv::Mat without_padding(PyramidLevel& level) {
  return with_padding(level)(cv::Rect(kPad, kPad, level.width, level.height));
}

void pad(PyramidLevel& level) {
  cv::copyMakeBorder(without_padding(level), with_padding(level), kPad, kPad, kPad, kPad,
                     cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
}

void copy_equalised(const cv::Mat& image, Equalisation equalisation, cv::Mat to) {
  switch (equalisation) {
    case Equalisation::kNone:
      image.copyTo(to);
      return;
    case Equalisation::kHistogram:
      cv::equalizeHist(image, to);
      return;
    case Equalisation::kClahe:
      cv::createCLAHE(3.0, cv::Size(8, 8))->apply(image, to);
      return;
  }
}

void require_size(const GrayImage& image) {
  const bool positive = image.width > kPad && image.height > kPad;
  if (positive && image.pixels.size() == static_cast<std::size_t>(image.width) *
                                             static_cast<std::size_t>(image.height)) {
    return;
  }
  throw InputError("image: found " + std::to_string(image.pixels.size()) + " pixels for " +
                   std::to_string(image.width) + " x " + std::to_string(image.height) +
                   ", expected width x height, each above " + std::to_string(kPad));
}

}  // namespace

void build_pyramid(const GrayImage& image, Equalisation equalisation, int levels,
                   ImagePyramid& pyramid) {
  require_size(image);
  const int smallest = std::min(image.width, image.height);
  int count = 1;
  while (count < levels && (smallest >> count) > kPad) ++count;
  pyramid.levels.resize(static_cast<std::size_t>(count));
  for (std::size_t l = 0; l < pyramid.levels.size(); ++l) {
    PyramidLevel& level = pyramid.levels[l];
    if (l == 0) {
      resize(level, image.width, image.height);
      // OpenCV's Mat requires a pointer to mutable pixels, but only reads them here.
      const cv::Mat pixels(image.height, image.width, CV_8UC1,
                           const_cast<std::uint8_t*>(image.pixels.data()));
      copy_equalised(pixels, equalisation, without_padding(level));
    } else {
      PyramidLevel& finer = pyramid.levels[l - 1];
      resize(level, (finer.width + 1) / 2, (finer.height + 1) / 2);
      cv::Mat coarse = without_padding(level);
      cv::pyrDown(without_padding(finer), coarse, coarse.size());
    }
    pad(level);
  }
}

Exposure exposure(const ImagePyramid& pyramid) {
  const PyramidLevel& level = pyramid.levels.back();
  const int pixels = level.width * level.height;
  int black = 0, white = 0;
  for (int y = 0; y < level.height; ++y) {
    const std::uint8_t* row = level.at(0, y);
    black += static_cast<int>(std::count_if(row, row + level.width, [](int v) { return v < 8; }));
    white += static_cast<int>(std::count_if(row, row + level.width, [](int v) { return v > 247; }));
  }
  if (black * 50 >= pixels * 49) return Exposure::kBlack;
  if (white * 50 >= pixels * 49) return Exposure::kSaturated;
  return Exposure::kUsable;
}

}  // namespace chasles
