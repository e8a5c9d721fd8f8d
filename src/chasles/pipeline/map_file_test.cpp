#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <zlib.h>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/loop/map_testing.hpp>
#include <chasles/loop/merge_maps.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

constexpr std::size_t kHead = 32;   // before what the first checksum covers
constexpr std::size_t kParts = 12;  // before what the second one covers

LandmarkMap some_map() {
  LandmarkMap map = test::corridor_map(2, 20, 10);
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500;
  camera.fy = 501;
  camera.distortion = Distortion::kRadtan;
  camera.coefficients = {0.1, -0.02, 0.001, 0.002};
  map.sessions.front().cameras = {camera, camera};
  return map;
}

std::string rejection(const std::string& bytes) {
  try {
    parse_map(bytes, "m.map");
    parse_map_parts(bytes, "m.map");
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

std::string section(const std::string& bytes) {
  const auto sum = static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
  const std::uint64_t size = bytes.size();
  std::string head(kParts, 0);
  std::memcpy(head.data(), &sum, sizeof sum);
  std::memcpy(head.data() + sizeof sum, &size, sizeof size);
  return head + bytes;
}

// What the checksums of a file cover.
struct Contents {
  std::string head, map, parts;
};

Contents contents(const std::string& file) {
  std::uint64_t size = 0;
  std::memcpy(&size, file.data() + kHead - sizeof size, sizeof size);
  return {.head = file.substr(0, kHead - kParts),
          .map = file.substr(kHead, size),
          .parts = file.substr(kHead + size + kParts)};
}

std::string file_of(const Contents& contents) {
  return contents.head + section(contents.map) + section(contents.parts);
}

// The same map as version 1 had it: with shared errors of 32 bits, and without parts.
std::string of_version_1(const std::string& file, const LandmarkMap& map) {
  const auto numbers = static_cast<std::size_t>(map.covariance.shared().size());
  Contents old = contents(file);
  old.head[16] = 1;
  const std::string halves = old.map.substr(old.map.size() - 2 * numbers);
  old.map.resize(old.map.size() - 2 * numbers);
  for (std::size_t i = 0; i < numbers; ++i) {
    Eigen::half half;
    std::memcpy(&half, halves.data() + 2 * i, sizeof half);
    const auto number = static_cast<float>(half);
    old.map.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  return old.head + section(old.map);
}

// Three walks through a corridor, as files.
std::vector<std::string> three_walks() {
  test::Random random(3);
  const LandmarkMap truth = test::corridor_map(7, 160, 40);
  std::vector<std::string> files;
  files.push_back(map_bytes(test::walk_map(truth, 0, 25, {}, 1, random)));
  files.push_back(
      map_bytes(test::walk_map(truth, 15, 40, test::level_pose(1, {4, 5, -1}), 2, random)));
  files.push_back(
      map_bytes(test::walk_map(truth, 5, 30, test::level_pose(-2, {1, 2, 3}), 3, random)));
  return files;
}

std::string merged(const std::vector<std::string>& files) {
  std::vector<MapPart> parts;
  for (const std::string& file : files) {
    for (LandmarkMap& part : parse_map_parts(file, "part")) parts.push_back({"part", part});
  }
  const MergedMaps result = merge_maps(std::move(parts));
  return map_bytes(result.map, result.parts);
}

// Earlier programs read a map whose lenses they know.
TEST(MapFile, EachLensIsReadAsItWasWritten) {
  for (const test::Lens& lens : test::lenses()) {
    LandmarkMap map = some_map();
    map.sessions.front().cameras = {lens.camera, lens.camera};
    const std::string bytes = map_bytes(map);
    const bool known =
        lens.camera.distortion <= Distortion::kEquidistant && lens.camera.coefficients.size() <= 5;
    EXPECT_EQ(bytes[16], known ? 2 : 3);
    const Camera read = parse_map(bytes, "m.map").sessions[0].cameras[1];
    EXPECT_EQ(read.distortion, lens.camera.distortion);
    EXPECT_EQ(read.coefficients, lens.camera.coefficients);
    EXPECT_EQ(read.fy, lens.camera.fy);
    EXPECT_EQ(map_bytes(parse_map(bytes, "m.map")), bytes);
  }
  LandmarkMap map = some_map();
  map.sessions.front().cameras[0].distortion = Distortion::kDoubleSphere;
  map.sessions.front().cameras[0].coefficients = {0, 2};
  EXPECT_NE(rejection(map_bytes(map)).find("a lens that cannot be"), std::string::npos);
  map.sessions.front().cameras[0].distortion = Distortion{77};
  EXPECT_NE(rejection(map_bytes(map)).find("an unknown lens"), std::string::npos);
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
  const Eigen::MatrixXd P = test::whole_covariance(map.covariance);
  const Eigen::VectorXd sigma = P.diagonal().cwiseSqrt();
  const Eigen::MatrixXd error = (P - test::whole_covariance(read.covariance))
                                    .cwiseQuotient(sigma * sigma.transpose())
                                    .cwiseAbs();
  EXPECT_LT(error.maxCoeff(), 0.001);
  // What is read is written as the same bytes.
  EXPECT_EQ(map_bytes(map), map_bytes(read));
  EXPECT_EQ(map_bytes(parse_map_parts(map_bytes(map), "m.map").at(0)), map_bytes(read));
}

TEST(MapFile, TakesLessThanAKilobyteALandmark) {
  const LandmarkMap map = test::corridor_map(2, 1000, 100);
  EXPECT_LT(map_bytes(map).size(), 1000 * 1000u);
}

TEST(MapFile, MergedInAnyOrderIsTheSameBytes) {
  const std::vector<std::string> walks = three_walks();
  const std::string all = merged(walks);
  std::vector<int> order{0, 1, 2};
  do {
    const auto walk = [&](std::size_t i) { return walks[static_cast<std::size_t>(order[i])]; };
    EXPECT_EQ(merged({walk(0), walk(1), walk(2)}), all);
    EXPECT_EQ(merged({merged({walk(0), walk(1)}), walk(2)}), all);
  } while (std::ranges::next_permutation(order).found);
  // A walk that both have counts once.
  EXPECT_EQ(merged({merged({walks[0], walks[1]}), merged({walks[2], walks[1]})}), all);
  EXPECT_EQ(merged({all, walks[0]}), all);
  EXPECT_EQ(merged({all, all}), all);
  EXPECT_EQ(merged({walks[0], walks[0]}), walks[0]);
}

TEST(MapFile, AMergedMapHasItsParts) {
  const std::vector<std::string> walks = three_walks();
  const std::string all = merged(walks);
  const std::vector<LandmarkMap> parts = parse_map_parts(all, "m.map");
  ASSERT_EQ(parts.size(), 3u);
  for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(map_bytes(parts[i]), walks[i]);
  const LandmarkMap map = parse_map(all, "m.map");
  EXPECT_EQ(map.sessions.size(), 3u);
  EXPECT_EQ(map_bytes(map, parts), all);
  // Descriptors that the merged map has are stored once.
  EXPECT_LT(contents(all).parts.size(),
            walks[0].size() + walks[1].size() + walks[2].size() - 96 * 100);
}

TEST(MapFile, OlderVersionsAreRead) {
  const std::vector<std::string> walks = three_walks();
  const LandmarkMap map = parse_map(walks[0], "m.map");
  const std::string old = of_version_1(walks[0], map);
  EXPECT_GT(old.size(), walks[0].size());
  EXPECT_EQ(map_bytes(parse_map(old, "m.map")), walks[0]);
  EXPECT_EQ(merged({walks[1], old}), merged({walks[0], walks[1]}));
  EXPECT_EQ(merged({walks[0], old}), walks[0]);
}

TEST(MapFile, OthersAreRejectedWithTheReason) {
  const std::string bytes = map_bytes(some_map());
  EXPECT_NE(rejection("").find("no map"), std::string::npos);
  EXPECT_NE(rejection("ply\nformat ascii 1.0\n").find("no map"), std::string::npos);
  std::string other = bytes;
  other[16] = 9;
  EXPECT_NE(rejection(other).find("found a map of version 9, expected at most 3"),
            std::string::npos);
  EXPECT_NE(rejection(bytes.substr(0, bytes.size() / 2)).find("bytes, expected"),
            std::string::npos);
  EXPECT_NE(rejection(bytes + "x").find("bytes, expected"), std::string::npos);
  other = bytes;
  other[bytes.size() / 2] ^= 1;
  EXPECT_NE(rejection(other).find("checksum"), std::string::npos);
  // The parts, too, are checked by whoever reads the map alone.
  const std::string several = merged(three_walks());
  other = several;
  other[other.size() - 10] ^= 1;
  EXPECT_NE(rejection(other).find("checksum"), std::string::npos);
  other.resize(other.size() - 10);
  EXPECT_NE(rejection(other).find("bytes, expected"), std::string::npos);
  other.resize(kHead + contents(several).map.size() + 3);
  EXPECT_NE(rejection(other).find("its end where more"), std::string::npos);
  // Sent as text: the line's end has become another one.
  other = bytes;
  other.replace(other.find("\r\n"), 2, "\n");
  EXPECT_NE(rejection(other).find("no map"), std::string::npos);
}

// Bytes at random places with right checksums: read, or rejected with an InputError.
void change_at_random(std::string& bytes, int trial, test::Random& random) {
  for (int i = 0; i < 1 + trial % 4; ++i) {
    // Often in the counts at the beginning.
    const std::size_t range =
        trial % 2 == 0 ? std::min<std::size_t>(400, bytes.size()) : bytes.size();
    bytes[random.next() % range] = static_cast<char>(random.next());
  }
  if (trial % 5 == 0) bytes.resize(random.next() % bytes.size());
}

TEST(MapFile, NoContentCrashesTheReader) {
  const Contents one = contents(map_bytes(some_map())), several = contents(merged(three_walks()));
  test::Random random(5);
  int rejected = 0, of_parts = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    Contents other = trial % 4 == 3 ? several : one;
    const bool in_parts = trial % 8 == 7;
    change_at_random(in_parts ? other.parts : other.map, trial / 8, random);
    const std::string found = rejection(file_of(other));
    (in_parts ? of_parts : rejected) += found != "read" ? 1 : 0;
    EXPECT_TRUE(found == "read" || found.find("m.map: ") == 0) << found;
  }
  EXPECT_GT(rejected, 500);
  EXPECT_GT(of_parts, 100);
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
