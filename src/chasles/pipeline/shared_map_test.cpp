#include <algorithm>
#include <array>
#include <unistd.h>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chasles/base/error.hpp>
#include <chasles/loop/extension_testing.hpp>
#include <chasles/loop/merge_maps.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/pipeline/shared_map.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::MapOfTruth;

// A map in a file, and what three runs in it left.
class SharedMapFile : public ::testing::Test {
 protected:
  SharedMapFile() {
    test::Random random(1);
    MapOfTruth base;
    base.map = test::walk_map(truth_, 8, 22, {}, 1, random, &base.indices);
    write_map(base.map, file_);
    base.map = read_map(file_);  // as runs read it
    opened_ = test::slurp(file_);
    runs_ = {test::extended_map(base, truth_, 12, 26, 2, random).map,
             test::extended_map(base, truth_, 12, 28, 3, random).map,
             test::extended_map(base, truth_, 2, 18, 4, random).map};
    other_ = test::walk_map(truth_, 0, 30, test::level_pose(1, {3, 1, 0}), 9, random);
  }
  void reset() const { test::spill(file_, opened_); }
  // All runs begin before the first one ends.
  std::string after(const std::vector<int>& order) const {
    reset();
    std::vector<SharedMap> maps;
    for (std::size_t i = 0; i < order.size(); ++i) maps.emplace_back(file_);
    for (std::size_t i = 0; i < order.size(); ++i) {
      const SharedMap::Saved saved = maps[i].save(runs_[static_cast<std::size_t>(order[i])]);
      EXPECT_EQ(saved.others, static_cast<int>(i));
      EXPECT_EQ(saved.bytes, fs::file_size(file_));
    }
    return test::slurp(file_);
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  const fs::path folder_ = test::scratch();
  const fs::path file_ = folder_ / "m.map";
  const LandmarkMap truth_ = test::corridor_map(7, 60, 30);
  std::string opened_;
  std::vector<LandmarkMap> runs_;
  LandmarkMap other_;
};

TEST_F(SharedMapFile, OneRunReplacesIt) {
  EXPECT_TRUE(after({1}) == map_bytes(runs_[1]));
  SharedMap map(file_);
  fs::remove(file_);
  EXPECT_EQ(map.save(runs_[0]).others, 0);  // it was removed meanwhile
  EXPECT_TRUE(test::slurp(file_) == map_bytes(runs_[0]));
  EXPECT_EQ(files(), 1u);
}

TEST_F(SharedMapFile, TheOrderOfTheEndsDoesNotMatter) {
  const std::string two = after({0, 1}), three = after({0, 1, 2});
  EXPECT_TRUE(after({1, 0}) == two);
  EXPECT_EQ(read_map(file_).sessions.size(), 3u);
  std::vector<int> order{0, 1, 2};
  while (std::ranges::next_permutation(order).found) EXPECT_TRUE(after(order) == three);
  EXPECT_EQ(read_map(file_).sessions.size(), 4u);
  EXPECT_EQ(read_map_parts(file_).size(), 4u);
  EXPECT_EQ(files(), 1u);
}

TEST_F(SharedMapFile, ARunMaySaveMoreThanOnce) {
  const std::string expected = after({0, 1});
  reset();
  SharedMap a(file_), b(file_);
  LandmarkMap early = runs_[0];
  early.points.front().observations -= 1;
  a.save(early);
  b.save(runs_[1]);
  a.save(runs_[0]);
  b.save(runs_[1]);
  EXPECT_TRUE(test::slurp(file_) == expected);
}

TEST_F(SharedMapFile, ProcessesAtTheSameTimeLoseNothing) {
  const std::string expected = after({0, 1, 2});
  for (int round = 0; round < 5; ++round) {
    reset();
    std::array<int, 2> go{}, ready{};
    ASSERT_EQ(::pipe(go.data()) + ::pipe(ready.data()), 0);
    std::vector<pid_t> children;
    for (const LandmarkMap& run : runs_) {
      children.push_back(::fork());
      if (children.back() != 0) continue;
      char byte = 0;
      ::close(go[1]);
      SharedMap map(file_);
      if (::write(ready[1], &byte, 1) != 1 || ::read(go[0], &byte, 1) != 0) ::_exit(2);
      try {
        map.save(run);
      } catch (const std::exception&) {
        ::_exit(1);
      }
      ::_exit(0);
    }
    char byte = 0;
    for (std::size_t i = 0; i < runs_.size(); ++i) ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    ::close(go[1]);
    for (const pid_t child : children) {
      int status = 0;
      ::waitpid(child, &status, 0);
      EXPECT_EQ(status, 0);
    }
    for (const int end : {go[0], ready[0], ready[1]}) ::close(end);
    EXPECT_TRUE(test::slurp(file_) == expected);
    EXPECT_EQ(files(), 1u);
  }
}

TEST_F(SharedMapFile, WhatWasMergedIntoItMeanwhileStays) {
  SharedMap map(file_);
  const MergedMaps with_other = merge_maps({{"m", read_map(file_), 0}, {"other", other_, 1}});
  write_map(with_other.map, file_, with_other.parts);
  EXPECT_EQ(map.save(runs_[0]).others, 1);
  const std::string first = test::slurp(file_);
  // The same where the run in the map ended before the merge.
  reset();
  SharedMap(file_).save(runs_[0]);
  const MergedMaps after = merge_maps({{"m", read_map(file_), 0}, {"other", other_, 1}});
  EXPECT_EQ(read_map_parts(file_).size(), 1u);
  EXPECT_EQ(after.parts.size(), 2u);
  write_map(after.map, file_, after.parts);
  EXPECT_EQ(read_map(file_).sessions.size(), 3u);
  test::spill(folder_ / "first.map", first);
  EXPECT_EQ(read_map(folder_ / "first.map").points.size(), read_map(file_).points.size());
}

TEST_F(SharedMapFile, AnotherMapInItsPlaceIsKept) {
  for (const bool damaged : {false, true}) {
    reset();
    SharedMap map(file_);
    test::Random random(8);
    write_map(test::walk_map(test::corridor_map(8, 60, 30), 0, 30, {}, 20, random), file_);
    if (damaged) test::spill(file_, "no map");
    const std::string now = test::slurp(file_);
    try {
      map.save(runs_[0]);
      ADD_FAILURE() << "merged";
    } catch (const InputError& error) {
      const std::string name = damaged ? "m-3.map" : "m-2.map";
      EXPECT_NE(std::string(error.what()).find("saved as " + (folder_ / name).string()),
                std::string::npos)
          << error.what();
      EXPECT_TRUE(test::slurp(folder_ / name) == map_bytes(runs_[0]));
    }
    EXPECT_TRUE(test::slurp(file_) == now);
  }
}

}  // namespace
}  // namespace chasles
