#include <settings_io.hpp>

#include <chasles/data/image_decode.hpp>
#include <chasles/data/image_testing.hpp>
#include <chasles/data/plan.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/slam/inertial_settings.hpp>

#include "kinds.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

// The expected size is that of the image, so that the size alone rejects nothing.
void decode(std::string_view bytes) { decode_image(bytes, stated_size(bytes, "input"), "input"); }

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

std::string jpeg_seed(const fs::path&) { return test::encoded(test::picture(10, 40, 30), ".jpg"); }
void read_jpeg(const fs::path&, std::string_view bytes) { decode(bytes); }

std::string tum_seed(const fs::path& scratch) {
  write_tum(test::drive({.frames = 8, .tracks = 1}).truth, scratch / "seed.tum");
  return test::slurp(scratch / "seed.tum");
}

void read_tum_bytes(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "input.tum", std::string(bytes));
  read_tum(scratch / "input.tum");
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
          {"jpeg", jpeg_seed, read_jpeg},
          {"tum", tum_seed, read_tum_bytes},
          {"plan", plan_seed, read_plan_bytes},
          {"settings", settings_seed, read_settings}};
}

}  // namespace chasles::fuzz
