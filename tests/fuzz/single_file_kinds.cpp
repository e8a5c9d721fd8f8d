#include <nlohmann/json.hpp>
#include <settings_io.hpp>

#include <chasles/codec/bomb_testing.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/mat_file.hpp>
#include <chasles/codec/png_testing.hpp>
#include <chasles/codec/yaml_map.hpp>
#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/plan.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/slam/inertial_settings.hpp>

#include "kinds.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

// The expected size is that of the image, so that the size alone rejects nothing.
// Large ones take time, and nothing else.
void decode(std::string_view bytes) {
  constexpr std::int64_t kMostPixels = 4'000'000;
  const ImageSize size = stated_size(bytes, "input");
  if (std::int64_t{size.width} * size.height > kMostPixels) throw InputError("a large image");
  largest_deep_value(bytes, size, "input");
  decode_image(bytes, size, "input", 12);
}

std::uint32_t big_endian(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

// Corrects the check sum of every part of a PNG; otherwise mutations would stop there.
std::string with_check_sums(std::string bytes) {
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const std::size_t size = big_endian(bytes, at);
    if (size > bytes.size() - at - 12) break;
    std::uint32_t sum = 0xffffffff;
    for (std::size_t i = at + 4; i < at + 8 + size; ++i) {
      sum ^= static_cast<unsigned char>(bytes[i]);
      for (int k = 0; k < 8; ++k) sum = (sum & 1) != 0 ? 0xedb88320 ^ (sum >> 1) : sum >> 1;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      bytes[at + 8 + size + i] = static_cast<char>(~sum >> (24 - 8 * i));
    }
    at += size + 12;
  }
  return bytes;
}

std::string png_seed(const fs::path&) { return test::picture_bytes(10); }
void read_png(const fs::path&, std::string_view bytes) {
  decode(with_check_sums(std::string(bytes)));
}

// The header of a PNG, a palette and filtered rows: a mutation of a whole PNG seldom has pixels
// whose check sum is right.
constexpr std::size_t kPngHeaderBytes = 13, kPaletteBytes = 12;
std::string png_pixels_seed(const fs::path&) {
  const test::PngKind kind{.width = 5, .height = 9, .depth = 2, .colour = 3, .interlaced = true};
  std::mt19937 random(1);
  return test::png_header_of(kind) + std::string(kPaletteBytes, 'p') +
         test::random_png_rows(kind, random);
}
void read_png_pixels(const fs::path&, std::string_view bytes) {
  const std::string input(bytes);
  if (input.size() < kPngHeaderBytes + kPaletteBytes) throw InputError("short");
  decode(test::png_of(input.substr(0, kPngHeaderBytes),
                      input.substr(kPngHeaderBytes, kPaletteBytes),
                      input.substr(kPngHeaderBytes + kPaletteBytes)));
}

std::string jpeg_seed(const fs::path&) { return test::encoded(test::picture(10, 40, 30), ".jpg"); }
void read_any_image(const fs::path&, std::string_view bytes) { decode(bytes); }

std::string pgm_seed(const fs::path&) { return "P2 # text\n3 2 4095\n0 1 2\n30 400 4095\n"; }
std::string bmp_seed(const fs::path&) {
  return test::encoded(cv::Mat(2, 2, CV_8UC3, cv::Scalar(1, 2, 3)), ".bmp");
}
std::string tiff_seed(const fs::path&) {
  return test::encoded(cv::Mat(3, 2, CV_16UC1, cv::Scalar(4000)), ".tiff");
}

std::string webp_seed(const fs::path&) { return test::encoded(test::picture(10), ".webp"); }

std::string tum_seed(const fs::path& scratch) {
  write_tum(test::drive({.frames = 8, .tracks = 1}).truth, scratch / "seed.tum");
  return test::slurp(scratch / "seed.tum");
}

void read_tum_bytes(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "input.tum", std::string(bytes));
  read_tum(scratch / "input.tum");
}

std::string json_seed(const fs::path&) {
  return R"({"name": "drive", "chart": "standard", "ate_m": 1.25, "remarks": ["a", "b"],
 "cameras": [{"imu_T_cam": [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}],
 "settings": {"gate": 0.99, "clones": 12, "velocity_axes": null}, "pairing": "nearest"})";
}

void read_json(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "summary.json", std::string(bytes));
  read_summary(scratch);
}

std::string yaml_seed(const fs::path&) {
  return "name: a\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0]\nlist:\n  - {a: 1, b: [2, "
         "3]}\n  - &x {a: 2, b: []}\nagain: *x\n";
}

void read_yaml(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "input.yaml", std::string(bytes));
  const YamlMap map = YamlMap::read(scratch / "input.yaml", {.known = {}, .needed = {"name"}});
  map.map("T_BS", {.known = {"cols", "rows", "data"}, .needed = {}}).numbers("data", 4, "numbers");
  map.maps("list", {.known = {}, .needed = {"a"}});
}

// Cells and structs, which a reader of numbers passes by: compressed or not.
std::string cells_seed(const fs::path&) {
  const std::string number = test::mat_element(
      14, test::mat_array_head(6, "n") + test::mat_element(9, std::string(8, '\0')));
  const std::string cells = test::nested_mat_cells(3);
  const std::string structure =
      test::mat_element(14, test::mat_array_head(2, "s") + test::mat_name_length(2) +
                                test::mat_element(1, std::string("a\0b\0", 4)) + number + cells);
  return test::mat_file(structure + cells + number + test::mat_compressed(structure));
}

void read_cells(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "input.mat", std::string(bytes));
  MatFile(scratch / "input.mat").read("n");
}

std::string plan_seed(const fs::path& scratch) {
  const Plan plan = {{.kind = PlanLine::Kind::kWall, .points = {{0, 0}, {2.5, 0}, {2.5, 4}}},
                     {.kind = PlanLine::Kind::kFurniture, .points = {{1, 1}, {1, 2}}}};
  write_plan_of(plan, scratch);
  return test::slurp(scratch / "plan.csv");
}

void read_plan_bytes(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "plan.csv", std::string(bytes));
  read_plan(scratch / "plan.csv");
}

std::string settings_seed(const fs::path&) {
  return "# a run\nchart: standard\nclones: 12\ngate: 0.99\nfirst_estimates: true\npixel_sigma: "
         "auto\n";
}

void read_settings(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "run.yaml", std::string(bytes));
  InertialSlamSettings settings;
  app::SettingCollector collector;
  for_each_setting(settings, collector);
  try {
    app::set_from_file(collector.settings, scratch / "run.yaml");
  } catch (const UsageError& error) {
    throw InputError(error.what());  // an invalid setting counts as malformed here
  }
}

}  // namespace

std::vector<Kind> single_file_kinds() {
  return {{"png", png_seed, read_png},
          {"png_pixels", png_pixels_seed, read_png_pixels},
          {"jpeg", jpeg_seed, read_any_image},
          {"pgm", pgm_seed, read_any_image},
          {"bmp", bmp_seed, read_any_image},
          {"tiff", tiff_seed, read_any_image},
          {"webp", webp_seed, read_any_image},
          {"tum", tum_seed, read_tum_bytes},
          {"json", json_seed, read_json},
          {"yaml", yaml_seed, read_yaml},
          {"mat_cells", cells_seed, read_cells},
          {"plan", plan_seed, read_plan_bytes},
          {"settings", settings_seed, read_settings}};
}

}  // namespace chasles::fuzz
