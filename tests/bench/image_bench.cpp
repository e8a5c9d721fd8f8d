// The processor time of decoding a PNG of 752 x 480 px to grey: ours, and OpenCV's (libpng) in the
// same run. The images are EuRoC's, or a made one if they are not available. One thread.

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <chasles/codec/image_decode.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
constexpr ImageSize kSize{.width = 752, .height = 480};
constexpr std::size_t kImages = 20;

// Waves with noise, as noisy as a real image.
std::string made_image() {
  cv::Mat image(kSize.height, kSize.width, CV_8UC1);
  cv::RNG random(1);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const double light = 120 + 60 * std::sin(0.05 * u) * std::cos(0.03 * v) + random.gaussian(2);
      image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(light);
    }
  }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_DEFAULT});
  return {bytes.begin(), bytes.end()};
}

const std::vector<std::string>& images() {
  static const std::vector<std::string> read = [] {
    const char* data = std::getenv("CHASLES_DATA");
    const fs::path folder =
        (data != nullptr ? fs::path(data) : fs::path(CHASLES_SOURCE_DIR) / "../shared/data") /
        "euroc/MH_01_easy_17s/mav0/cam0/data";
    std::vector<std::string> bytes;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none)) {
      if (bytes.size() == kImages) break;
      std::ifstream file(entry.path(), std::ios::binary);
      bytes.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    if (bytes.empty()) bytes.push_back(made_image());
    return bytes;
  }();
  return read;
}

template <typename Decode>
void decode_all(benchmark::State& state, Decode&& decode) {
  std::size_t i = 0;
  images();
  for (auto _ : state) benchmark::DoNotOptimize(decode(images()[i++ % images().size()]));
}

void ours(benchmark::State& state) {
  decode_all(state, [](const std::string& png) { return decode_image(png, kSize, "image"); });
}

void opencv(benchmark::State& state) {
  decode_all(state, [](const std::string& png) {
    return cv::imdecode(std::vector<std::uint8_t>(png.begin(), png.end()), cv::IMREAD_GRAYSCALE);
  });
}

BENCHMARK(ours)->Unit(benchmark::kMillisecond);
BENCHMARK(opencv)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace chasles

BENCHMARK_MAIN();
