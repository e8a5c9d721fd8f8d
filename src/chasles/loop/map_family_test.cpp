#include <algorithm>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/loop/extension_testing.hpp>
#include <chasles/loop/map_family.hpp>

namespace chasles {
namespace {

using test::MapOfTruth;

// A map, three runs in it, and one in the map that the first run left.
struct Family {
  LandmarkMap truth = test::corridor_map(7, 90, 30);
  MapOfTruth base, a, b, c, after_a;
  LandmarkMap other;  // a walk of its own in the same corridor

  explicit Family(std::uint64_t seed) {
    test::Random random(seed);
    base.map = test::walk_map(truth, 8, 22, {}, 1, random, &base.indices);
    a = test::extended_map(base, truth, 12, 26, 2, random);
    b = test::extended_map(base, truth, 12, 28, 3, random);
    c = test::extended_map(base, truth, 2, 18, 4, random);
    after_a = test::extended_map(a, truth, 14, 29, 5, random);
    other = test::walk_map(truth, 0, 30, test::level_pose(1, {3, 1, 0}), 9, random);
  }
};

MergedMaps merged(std::vector<LandmarkMap> maps) {
  std::vector<MapPart> parts;
  for (LandmarkMap& map : maps) parts.push_back({"m", std::move(map), 0});
  return merge_maps(std::move(parts));
}

// As a file has them.
std::vector<LandmarkMap> of_file(const MergedMaps& maps) {
  return maps.parts.empty() ? std::vector{maps.map} : maps.parts;
}

MergedMaps with(std::vector<LandmarkMap> file, std::vector<LandmarkMap> more) {
  file.insert(file.end(), more.begin(), more.end());
  return merged(std::move(file));
}

bool are_same(const MergedMaps& x, const MergedMaps& y) {
  return is_same_map(x.map, y.map) &&
         std::ranges::equal(x.parts, y.parts,
                            [](const auto& a, const auto& b) { return is_same_map(a, b); });
}

TEST(MapFamily, WhicheverRunEndsFirstTheMapIsTheSame) {
  const Family f(1);
  const MergedMaps all = merged({f.base.map, f.a.map, f.b.map, f.c.map});
  EXPECT_EQ(all.map.sessions.size(), 4u);
  EXPECT_EQ(all.parts.size(), 4u);
  EXPECT_TRUE(all.joined.empty());
  std::vector<int> order{0, 1, 2};
  const LandmarkMap* runs[] = {&f.a.map, &f.b.map, &f.c.map};
  do {  // each run merges what it left into the file of those that ended before
    std::vector<LandmarkMap> file{*runs[order[0]]};
    MergedMaps now = with(file, {f.base.map, *runs[order[1]]});
    now = with(of_file(now), {f.base.map, *runs[order[2]]});
    EXPECT_TRUE(are_same(now, all));
  } while (std::ranges::next_permutation(order).found);
}

TEST(MapFamily, ARunInTheMapOfAnotherReplacesThat) {
  const Family f(2);
  const MergedMaps all = merged({f.base.map, f.after_a.map, f.b.map});
  EXPECT_EQ(all.parts.size(), 3u);
  EXPECT_TRUE(is_same_map(merged({f.base.map, f.a.map, f.after_a.map}).map, f.after_a.map));
  EXPECT_TRUE(merged({f.base.map, f.a.map, f.after_a.map}).parts.empty());
  // b ends before or after the second run in the map of a.
  const MergedMaps b_first = merged({f.base.map, f.a.map, f.b.map});
  EXPECT_TRUE(are_same(with(of_file(b_first), {f.a.map, f.after_a.map}), all));
  EXPECT_TRUE(are_same(with({f.after_a.map}, {f.base.map, f.b.map}), all));
}

TEST(MapFamily, IsMergedWithOtherWalksAsOneMap) {
  const Family f(3);
  const std::vector<LandmarkMap> family{f.base.map, f.a.map, f.b.map};
  std::vector<MapPart> parts;
  for (const LandmarkMap& map : family) parts.push_back({"family", map, 0});
  parts.push_back({"other", f.other, 1});
  parts.push_back({"copy", f.base.map, 2});
  const MergedMaps all = merge_maps(parts);
  ASSERT_EQ(all.joined.size(), 1u);
  EXPECT_EQ(all.joined.front().sessions.front().name, "walk-9");
  EXPECT_EQ(all.map.sessions.size(), 4u);
  EXPECT_EQ(all.parts.size(), 4u);
  std::ranges::reverse(parts);
  EXPECT_TRUE(are_same(merge_maps(parts), all));
}

TEST(MapFamily, OfSeveralFilesWouldCountTwice) {
  const Family f(4);
  const auto rejected = [](std::vector<MapPart> parts) -> std::string {
    try {
      map_families(std::move(parts));
    } catch (const InputError& error) {
      return error.what();
    }
    return "joined";
  };
  EXPECT_NE(rejected({{"a", f.a.map, 0}, {"b", f.b.map, 1}}).find("count it twice"),
            std::string::npos);
  EXPECT_NE(rejected({{"base", f.base.map, 0}, {"a", f.a.map, 1}}).find("count it twice"),
            std::string::npos);
  // Two runs of one recording.
  LandmarkMap again = f.a.map;
  again.points.front().p_map.x() += 0.01;
  EXPECT_NE(
      rejected({{"m", f.base.map, 0}, {"m", f.a.map, 0}, {"m", again, 0}}).find("count it twice"),
      std::string::npos);
  EXPECT_EQ(rejected({{"m", f.base.map, 0}, {"m", f.a.map, 0}, {"m", f.a.map, 0}}), "joined");
}

}  // namespace
}  // namespace chasles
