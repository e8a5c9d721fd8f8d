#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/run_folder/shown_images.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kImageColumns = {"time_ns", "camera", "width", "height", "image"};
const std::vector<std::string> kImageFeatureColumns = {
    "time_ns",  "camera",     "landmark",   "u",      "v",      "age",    "u_before",
    "v_before", "u_expected", "v_expected", "cov_uu", "cov_uv", "cov_vv", "outcome"};
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kLargestSide = 1'000'000;  // of an image [px]

std::string picture_name(const ShownImage& image) {
  return fmt::format("images/cam{}_{}.jpg", image.camera, image.time.count());
}

void append_features(const ShownImage& image, fmt::memory_buffer& rows) {
  const Eigen::Vector2d none(kNone, kNone);
  for (const ImageFeature& f : image.features) {
    const PixelObservation& seen = f.seen.observation;
    const Eigen::Vector2d before = f.before.value_or(none);
    const ExpectedPixel expected = f.seen.expected.value_or(
        ExpectedPixel{.pixel = none, .covariance = Eigen::Matrix2d::Constant(kNone)});
    const Eigen::Matrix2d& S = expected.covariance;
    fmt::format_to(std::back_inserter(rows),
                   "{},{},{},{:.2f},{:.2f},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.4g},{:.4g},{:.4g},"
                   "{}\n",
                   image.time.count(), image.camera, seen.landmark, seen.pixel.x(), seen.pixel.y(),
                   f.age, before.x(), before.y(), expected.pixel.x(), expected.pixel.y(), S(0, 0),
                   S(0, 1), S(1, 1), name(f.seen.outcome));
  }
}

int whole(const CsvReader& csv, std::size_t column, int most) {
  const std::int64_t value = csv.integer(column);
  if (value >= 0 && value <= most) return static_cast<int>(value);
  throw InputError(fmt::format("{}: found {}, expected 0 to {}", csv.where(column), value, most));
}

std::string read_picture(const CsvReader& csv, const ShownImage& image, const fs::path& folder) {
  if (csv.text(4).empty()) return {};
  const std::string expected = picture_name(image);
  if (csv.text(4) != expected) {
    throw InputError(fmt::format("{}: found '{:.80}', expected {} or nothing", csv.where(4),
                                 csv.text(4), expected));
  }
  const fs::path file = folder / expected;
  std::string bytes = read_file(file);
  if (stated_size(bytes, file.string()).width > image.width) {
    throw InputError(
        fmt::format("{}: is wider than its camera's {} px", file.string(), image.width));
  }
  return bytes;
}

std::optional<Eigen::Vector2d> pixel(const CsvReader& csv, std::size_t column) {
  const Eigen::Vector2d found(csv.number(column), csv.number(column + 1));
  if (found.allFinite()) return found;
  return std::nullopt;
}

ImageFeature read_feature(const CsvReader& csv) {
  ImageFeature f;
  f.seen.observation = {.landmark = csv.integer(2),
                        .camera = whole(csv, 1, kLargestSide),
                        .pixel = {csv.finite(3), csv.finite(4)}};
  f.age = whole(csv, 5, std::numeric_limits<int>::max());
  f.before = pixel(csv, 6);
  if (const auto expected = pixel(csv, 8)) {
    const double uv = csv.number(11);
    f.seen.expected = ExpectedPixel{.pixel = *expected, .covariance = Eigen::Matrix2d::Zero()};
    f.seen.expected->covariance << csv.number(10), uv, uv, csv.number(12);
  }
  const auto outcome = outcome_of(csv.text(13));
  if (!outcome) {
    throw InputError(fmt::format("{}: found '{:.40}', expected waiting, begun, used or rejected",
                                 csv.where(13), csv.text(13)));
  }
  f.seen.outcome = *outcome;
  return f;
}

bool is_of(const ShownImage& image, const CsvReader& csv) {
  return image.time == csv.time(0) && image.camera == csv.integer(1);
}

// Rows of one image are consecutive, in the order of images.csv.
void read_features(const fs::path& file, std::vector<ShownImage>& images) {
  CsvReader csv(file, kImageFeatureColumns, {}, LastLine::kMustEnd);
  auto image = images.begin();
  while (csv.next()) {
    while (image != images.end() && !is_of(*image, csv)) ++image;
    if (image == images.end()) {
      throw InputError(
          fmt::format("{}: is of no image of images.csv, or out of its order", csv.where(0)));
    }
    image->features.push_back(read_feature(csv));
  }
}

}  // namespace

std::vector<std::string> pictures_of(const fs::path& folder) {
  std::error_code none;
  std::vector<std::string> pictures;
  for (const auto& entry : fs::directory_iterator(folder / "images", none)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with("cam") && file.ends_with(".jpg")) pictures.push_back("images/" + file);
  }
  return pictures;
}

void write_shown_images(const std::vector<ShownImage>& images, const fs::path& folder) {
  if (images.empty()) return;
  fmt::memory_buffer rows, features;
  for (const ShownImage& image : images) {
    const std::string file = image.jpeg.empty() ? "" : picture_name(image);
    fmt::format_to(std::back_inserter(rows), "{},{},{},{},{}\n", image.time.count(), image.camera,
                   image.width, image.height, file);
    append_features(image, features);
    if (file.empty()) continue;
    make_folder(folder / "images");
    write_file(folder / file, image.jpeg);
  }
  write_table(folder / "images.csv", kImageColumns, {rows.data(), rows.size()});
  write_table(folder / "features.csv", kImageFeatureColumns, {features.data(), features.size()});
}

std::vector<ShownImage> read_shown_images(const fs::path& folder) {
  std::vector<ShownImage> images;
  if (!fs::exists(folder / "images.csv")) return images;
  CsvReader csv(folder / "images.csv", kImageColumns, {}, LastLine::kMustEnd);
  while (csv.next()) {
    ShownImage image{.time = csv.time(0),
                     .camera = whole(csv, 1, kLargestSide),
                     .width = whole(csv, 2, kLargestSide),
                     .height = whole(csv, 3, kLargestSide),
                     .jpeg = {},
                     .features = {}};
    const auto key = [](const ShownImage& i) { return std::pair(i.time, i.camera); };
    if (!images.empty() && key(image) <= key(images.back())) {
      throw InputError(fmt::format("{}: time and camera do not rise", csv.where()));
    }
    image.jpeg = read_picture(csv, image, folder);
    images.push_back(std::move(image));
  }
  read_features(folder / "features.csv", images);
  return images;
}

}  // namespace chasles
