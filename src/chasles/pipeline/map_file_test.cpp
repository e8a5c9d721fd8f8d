#include <cmath>
#include <cstring>
#include <fstream>
#include <zlib.h>

#include <gtest/gtest.h>

#include <chasles/data/testing.hpp>
#include <chasles/error.hpp>
#include <chasles/map/map_testing.hpp>
#include <chasles/pipeline/map_file.hpp>

namespace chasles {
namespace {

constexpr std::size_t kHead = 32;  // before what the checksum covers

LandmarkMap some_map() {
  LandmarkMap map = test::corridor_map(2, 20, 10);
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500;
  camera.fy = 501;
  camera.distortion = Distortion::kRadtan;
  camera.coefficients << 0.1, -0.02, 0.001, 0.002;
  map.sessions.front().cameras = {camera, camera};
  return map;
}

std::string refusal(const std::string& bytes) {
  try {
    parse_map(bytes, "m.map");
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

std::string with_checksum(std::string bytes) {
  const auto sum = static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data() + kHead), bytes.size() - kHead));
  std::memcpy(bytes.data() + 20, &sum, sizeof sum);
  return bytes;
}

TEST(MapFile, IsReadAsItWasWritten) {
  const LandmarkMap map = some_map(), read = parse_map(map_bytes(map), "m.map");
  ASSERT_EQ(read.sessions.size(), 1u);
  EXPECT_EQ(read.sessions[0].name, "corridor");
  EXPECT_EQ(read.sessions[0].begin, Time(5));
  ASSERT_EQ(read.sessions[0].cameras.size(), 2u);
  EXPECT_EQ(read.sessions[0].cameras[1].fy, 501);
  EXPECT_EQ(read.sessions[0].cameras[1].coefficients, map.sessions[0].cameras[1].coefficients);
  ASSERT_EQ(read.points.size(), map.points.size());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const MapPoint &a = map.points[i], &b = read.points[i];
    EXPECT_EQ(a.p_map, b.p_map);
    EXPECT_EQ(a.observations, b.observations);
    ASSERT_EQ(a.appearance.views().size(), b.appearance.views().size());
    const PatchView &v = a.appearance.views()[0], &w = b.appearance.views()[0];
    EXPECT_EQ(v.descriptors, w.descriptors);
    EXPECT_EQ(v.level, w.level);
    EXPECT_LT((v.from - w.from).norm(), 0.01);
  }
  EXPECT_TRUE(test::agree(test::whole_covariance(map.covariance),
                          test::whole_covariance(read.covariance), 1e-6, 1e-12));
  // What is read is written as the same bytes.
  EXPECT_EQ(map_bytes(read), map_bytes(parse_map(map_bytes(read), "m.map")));
}

TEST(MapFile, TakesLessThanAKilobyteALandmark) {
  const LandmarkMap map = test::corridor_map(2, 1000, 100);
  EXPECT_LT(map_bytes(map).size(), 1000 * 1000u);
}

TEST(MapFile, OthersAreRefusedWithTheReason) {
  const std::string bytes = map_bytes(some_map());
  EXPECT_NE(refusal("").find("no map"), std::string::npos);
  EXPECT_NE(refusal("ply\nformat ascii 1.0\n").find("no map"), std::string::npos);
  std::string other = bytes;
  other[16] = 9;
  EXPECT_NE(refusal(other).find("found a map of version 9, expected 1"), std::string::npos);
  EXPECT_NE(refusal(bytes.substr(0, bytes.size() / 2)).find("bytes, expected"), std::string::npos);
  EXPECT_NE(refusal(bytes + "x").find("bytes, expected"), std::string::npos);
  other = bytes;
  other[bytes.size() / 2] ^= 1;
  EXPECT_NE(refusal(other).find("checksum"), std::string::npos);
  // Sent as text: the line's end has become another one.
  other = bytes;
  other.replace(other.find("\r\n"), 2, "\n");
  EXPECT_NE(refusal(other).find("no map"), std::string::npos);
}

// Bytes at random places with a right checksum: read, or refused with an InputError.
TEST(MapFile, NoContentCrashesTheReader) {
  const std::string bytes = map_bytes(some_map());
  test::Random random(5);
  int refused = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::string other = bytes;
    for (int i = 0; i < 1 + trial % 4; ++i) {
      // Often in the counts at the beginning.
      const std::size_t range = trial % 2 == 0 ? 400 : bytes.size() - kHead;
      other[kHead + random.next() % range] = static_cast<char>(random.next());
    }
    if (trial % 5 == 0) other.resize(kHead + random.next() % (bytes.size() - kHead));
    const std::uint64_t size = other.size() - kHead;
    std::memcpy(other.data() + 24, &size, sizeof size);
    const std::string found = refusal(with_checksum(other));
    refused += found != "read" ? 1 : 0;
    EXPECT_TRUE(found == "read" || found.find("m.map: ") == 0) << found;
  }
  EXPECT_GT(refused, 500);
}

TEST(MapFile, WhatCouldNotBeReadIsNotWritten) {
  LandmarkMap map = some_map();
  map.points[3].appearance = {};
  EXPECT_THROW(map_bytes(map), UsageError);
  map = some_map();
  map.points[3].p_map.x() = std::nan("");
  EXPECT_THROW(map_bytes(map), UsageError);
}

TEST(MapFile, ReplacesTheOldOneAsAWhole) {
  const std::filesystem::path folder = test::scratch();
  const auto file = folder / "m.map";
  write_map(some_map(), file);
  write_map(test::corridor_map(3, 5, 10), file);
  EXPECT_EQ(read_map(file).points.size(), 5u);
  EXPECT_FALSE(std::filesystem::exists(file.string() + ".part"));
  EXPECT_THROW(write_map(some_map(), folder / "none/m.map"), UsageError);
  EXPECT_THROW(read_map(folder / "none.map"), InputError);
  EXPECT_THROW(read_map(folder), InputError);
}

}  // namespace
}  // namespace chasles
