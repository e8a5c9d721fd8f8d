#include <array>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/bags/decompress.hpp>
#include <chasles/bags/ros_image.hpp>
#include <chasles/bags/ros_messages.hpp>
#include <chasles/base/error.hpp>
#include <chasles/recording/readers.hpp>

#include "kinds.hpp"
#include "use_recording.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

void read_bag_bytes(const fs::path& scratch, std::string_view bytes) {
  const fs::path folder = scratch / "bag";
  fs::create_directories(folder);
  test::write_kalibr(folder);
  test::spill(folder / "walk", std::string(bytes));
  use(read_bag_recording(folder / "walk"));
}

// The bag's own calibration.
void read_calibrated_bytes(const fs::path& scratch, std::string_view bytes) {
  const fs::path folder = scratch / "calibrated";
  fs::create_directories(folder);
  test::spill(folder / "imu.yaml", test::kKalibrImu);
  test::spill(folder / "walk", std::string(bytes));
  use(read_bag_recording(folder / "walk"));
}

// Without check sums, so that mutations reach the structure.
std::string bag_seed(const fs::path&) { return test::slurp(test::written_bag("none.bag")); }
std::string mcap_seed(const fs::path&) { return test::slurp(test::written_bag("unchecked.mcap")); }
std::string packed_seed(const fs::path&) { return test::slurp(test::written_bag("zstd.mcap")); }
std::string db3_seed(const fs::path&) { return test::slurp(test::written_bag("db3/db3.db3")); }
std::string calibrated_seed(const fs::path&) {
  return test::slurp(test::written_bag("calibrated.bag"));
}

// The first byte chooses the type, the second the serialisation.
std::string message_seed(const fs::path&) {
  return std::string("\1\0", 2) +
         test::image_message(test::kStamp, test::picture(10), "bayer_rggb8");
}

void read_message(const fs::path&, std::string_view bytes) {
  if (bytes.size() < 2) throw InputError("too short");
  const RosMessage message{.bytes = bytes.substr(2),
                           .wire = bytes[1] % 2 == 0 ? Wire::kRos1 : Wire::kCdr};
  switch (bytes[0] & 7) {
    case 0:
      ros_imu(message);
      break;
    case 1: {
      const RosImage image = ros_image(message);
      // The expected size is that of the image, so that it alone rejects nothing.
      if (image.width > 4096 || image.height > 4096) throw InputError("too large");
      const ImageSize size{static_cast<int>(image.width), static_cast<int>(image.height)};
      grey_image(image, size, largest_deep_value(image, size, "image") ? 12 : 8, "image");
      break;
    }
    case 2:
      ros_compressed_image(message);
      break;
    case 3:
      ros_camera_info(message);
      break;
    default:
      ros_transforms(message);
  }
}

// The first byte chooses the compression.
std::string chunk_seed(const fs::path&) {
  return "\2" + test::slurp(test::written_bag("db3_file/db3_file.db3.zstd"));
}

void read_chunk_bytes(const fs::path&, std::string_view bytes) {
  if (bytes.empty()) throw InputError("too short");
  constexpr std::array<const char*, 3> kNames{"bz2", "lz4", "zstd"};
  decompress(bytes.substr(1), kNames[static_cast<unsigned char>(bytes[0]) % 3], 1 << 20, "chunk");
}

}  // namespace

std::vector<Kind> bag_kinds() {
  return {{"bag", bag_seed, read_bag_bytes},
          {"bag_calibrated", calibrated_seed, read_calibrated_bytes},
          {"mcap", mcap_seed, read_bag_bytes},
          {"mcap_packed", packed_seed, read_bag_bytes},
          {"db3", db3_seed, read_bag_bytes},
          {"ros_message", message_seed, read_message},
          {"chunk", chunk_seed, read_chunk_bytes}};
}

}  // namespace chasles::fuzz
