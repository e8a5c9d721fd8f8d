#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/inertial_testing.hpp>
#include <chasles/recording/readers.hpp>

#include "kinds.hpp"
#include "parts.hpp"
#include "use_recording.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

// The first instants of a recording with frames, truth and landmarks.
std::string recording_seed(const fs::path& scratch) {
  Recording r = test::inertial();
  r.imu.resize(24);
  r.truth.resize(2);
  r.true_motion.resize(2);
  r.frames.resize(2);
  write_folder_recording(r, scratch / "inertial");
  return pack(parts_of(scratch / "inertial"));
}

void read_recording_parts(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_folder_recording(scratch / "input"));
}

std::string imu_table() { return test::kEurocImuColumns + test::five_samples(); }

std::string imu_seed(const fs::path&) {
  return pack({{"hall_imu.csv", imu_table()},
               {"hall_gt.csv", std::string(test::kEurocStateColumns) +
                                   "5000000,1,2,3,1,0,0,0,4,5,6,7,8,9,10,11,12\n"
                                   "10000000,1,2,4,1,0,0,0,4,5,6,7,8,9,10,11,12\n"}});
}

void read_imu_parts(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_euroc_imu_recording(scratch / "input" / "hall_imu.csv"));
}

// A gzip file of one stored block. It is as good as a compressed one: mutations reach the
// structure.
std::string gzip_seed(const fs::path&) {
  const std::string text = imu_table();
  std::string bytes(
      "\x1f\x8b\x08\x08\0\0\0\0\x02\xff"
      "imu.csv\0\x01",
      19);
  const auto append = [&](std::size_t value, int size) {
    for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 255);
  };
  append(text.size(), 2);
  append(~text.size(), 2);
  bytes += text;
  std::uint32_t sum = 0xffffffff;
  for (const char c : text) {
    sum ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) sum = (sum & 1) != 0 ? 0xedb88320 ^ (sum >> 1) : sum >> 1;
  }
  append(~sum, 4);
  append(text.size(), 4);
  return bytes;
}

void read_gzip(const fs::path& scratch, std::string_view bytes) {
  fs::create_directories(scratch / "zipped");
  test::spill(scratch / "zipped" / "hall_imu.csv.gz", std::string(bytes));
  use(read_recording(scratch / "zipped" / "hall_imu.csv.gz"));
}

std::string klt_seed(const fs::path&) {
  return pack({{"hall_klt_tracks_cam0.csv",
                "#timestamp [ns],track_id,u [px],v [px]  (raw distorted pixels)\n"
                "5000000,0,3,4\n5000000,1,7,2.5\n10000000,0,3.5,4\n"},
               {"hall_imu.csv", imu_table()},
               {"cam0_sensor.yaml", test::kEurocCamera0}});
}

void read_klt(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_klt_tracks_recording(scratch / "input" / "hall_klt_tracks_cam0.csv"));
}

std::string april_seed(const fs::path&) {
  return pack({{"tracks.csv",
                "#timestamp [ns],cam,corner_id(=4*tag),u [px],v [px]\n5000000,0,5,3,4\n"
                "5000000,1,5,2,4\n10000000,0,5,3.5,4\n"},
               {"imu0.csv", imu_table()},
               {"cam0_sensor.yaml", test::kEurocCamera0},
               {"cam1_sensor.yaml", test::kEurocCamera0},
               {"imu0_sensor.yaml", test::kEurocImu0}});
}

void read_april(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_april_recording(scratch / "input"));
}

}  // namespace

std::vector<Kind> inertial_kinds() {
  return {{"recording", recording_seed, read_recording_parts},
          {"imu", imu_seed, read_imu_parts},
          {"gzip", gzip_seed, read_gzip},
          {"klt", klt_seed, read_klt},
          {"april", april_seed, read_april}};
}

}  // namespace chasles::fuzz
