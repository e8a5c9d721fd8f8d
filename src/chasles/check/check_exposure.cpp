#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/check/check_exposure.hpp>

namespace chasles {
namespace {

constexpr std::size_t kDark = 10, kBright = 250;
constexpr double kDarkShare = 0.5, kBrightShare = 0.2;
constexpr double kLeastContrast = 4;  // a covered lens has only noise
constexpr double kImagesRepeat = 0.02;
constexpr double kMissingImages = 0.1;  // share of the frames

// Sums over the frames examined.
struct CameraSums {
  double mean = 0, dark = 0, bright = 0;
  int images = 0, blank = 0, repeated = 0, missing = 0;

  void add(const GrayImage& image) {
    if (image.empty()) {
      ++missing;
      return;
    }
    const ImageExposure exposure = exposure_of(image);
    mean += exposure.mean;
    dark += exposure.dark;
    bright += exposure.bright;
    blank += exposure.contrast < kLeastContrast ? 1 : 0;
    ++images;
  }
};

class Damages {
 public:
  explicit Damages(const ImageSource& images) : images_(&images) {}
  // The frame with the images that can be read; nothing if none can. The others are counted.
  std::optional<ImageFrame> read(std::size_t i, std::size_t cameras) {
    ++tried_;
    std::optional<ImageFrame> frame;
    bool damaged = false;
    const auto note = [&](const InputError& error) {
      if (damaged_ == 0 && !damaged) first_ = error.what();
      damaged = true;
    };
    try {
      frame = images_->read_undamaged(i, cameras, note);
    } catch (const InputError& error) {
      note(error);
    }
    damaged_ += damaged ? 1 : 0;
    return frame;
  }
  bool any() const { return damaged_ > 0; }
  void report(CheckReport& report) const {
    if (damaged_ == 0) return;
    report.findings.push_back(
        {.severity = Severity::kError,
         .about = "images",
         .what = fmt::format("{} of the {} frames examined have an image that cannot be read; the "
                             "first: {}",
                             damaged_, tried_, first_),
         .value = static_cast<double>(damaged_),
         .threshold = 0,
         .unit = "frames",
         .advice = "copy the recording again, or remove these images from its table"});
  }

 private:
  const ImageSource* images_;
  int tried_ = 0, damaged_ = 0;
  std::string first_;
};

void report_share(const std::string& about, double share, double limit, const std::string& what,
                  const std::string& advice, CheckReport& report) {
  if (share <= limit) return;
  report.findings.push_back({.severity = Severity::kWarning,
                             .about = about,
                             .what = fmt::format("{:.0f} % of {}", 100 * share, what),
                             .value = 100 * share,
                             .threshold = 100 * limit,
                             .unit = "%",
                             .advice = advice});
}

// Frames in which one camera of a rig has no image: its stamps differ, or images are lost.
void report_missing(const std::string& about, const CameraSums& sums, CheckReport& report) {
  const double frames = sums.images + sums.missing;
  if (frames == 0) return;
  report_share(
      about, sums.missing / frames, kMissingImages, "the frames examined have no image of it",
      "trigger the cameras together: a frame takes images whose stamps differ by at most 2 "
      "ms (see the remarks of the reader); or images were lost",
      report);
}

void report_camera(const std::string& about, const CameraSums& sums, CheckReport& report) {
  if (sums.images == 0) return;
  const double n = sums.images;
  report.facts.push_back({about, "brightness", sums.mean / n, "of 255"});
  report.facts.push_back({about, "dark", 100 * sums.dark / n, "%"});
  report.facts.push_back({about, "saturated", 100 * sums.bright / n, "%"});
  report_share(about, sums.dark / n, kDarkShare, "the pixels are dark", "expose longer", report);
  report_share(about, sums.bright / n, kBrightShare, "the pixels are saturated",
               "expose for a shorter time", report);
  report_share(about, sums.blank / n, 0, "the images show nothing",
               "check whether the lens was covered or the light was off", report);
  report_share(about, sums.repeated / n, kImagesRepeat, "the images repeat the one before",
               "check the camera's driver: a filter takes a frozen image as no motion", report);
}

}  // namespace

ImageExposure exposure_of(const GrayImage& image) {
  std::array<std::size_t, 256> histogram{};
  for (const std::uint8_t pixel : image.pixels) ++histogram[pixel];
  ImageExposure exposure;
  double square = 0;
  for (std::size_t shade = 0; shade < histogram.size(); ++shade) {
    const double share =
        static_cast<double>(histogram[shade]) / static_cast<double>(image.pixels.size());
    const auto value = static_cast<double>(shade);
    exposure.mean += share * value;
    square += share * value * value;
    exposure.dark += shade <= kDark ? share : 0;
    exposure.bright += shade >= kBright ? share : 0;
  }
  exposure.contrast = std::sqrt(std::max(0.0, square - exposure.mean * exposure.mean));
  return exposure;
}

void report_exposure(const ImageSource& images, std::size_t cameras, std::size_t most,
                     CheckReport& report) {
  const std::size_t pairs = std::min(most, images.size() - std::min<std::size_t>(images.size(), 1));
  std::vector<CameraSums> sums(cameras);
  Damages files(images);
  for (std::size_t n = 0; n < pairs; ++n) {
    const std::size_t k = n * (images.size() - 1) / pairs;
    const auto first = files.read(k, cameras), second = files.read(k + 1, cameras);
    for (std::size_t c = 0; first && c < cameras; ++c) {
      sums[c].add(first->images[c]);
      if (!second || first->images[c].empty()) continue;
      sums[c].repeated += first->images[c].pixels == second->images[c].pixels ? 1 : 0;
    }
  }
  files.report(report);
  for (std::size_t c = 0; c < cameras && cameras > 1 && !files.any(); ++c) {
    report_missing(fmt::format("cam{}", c), sums[c], report);
  }
  for (std::size_t c = 0; c < cameras; ++c) report_camera(fmt::format("cam{}", c), sums[c], report);
}

}  // namespace chasles
