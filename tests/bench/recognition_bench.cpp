#include <numeric>

#include <benchmark/benchmark.h>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/past/segment_chain.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/loop/appearance.hpp>
#include <chasles/loop/joint_compatibility.hpp>
#include <chasles/loop/map_testing.hpp>
#include <chasles/loop/place.hpp>
#include <chasles/pipeline/map_file.hpp>

// The steps of recognition (docs/recognition.md): describing, matching, recalling, returning.

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(test::Random& random, Index rows, Index columns, double sigma) {
  MatrixXd M(rows, columns);
  for (double& m : M.reshaped()) m = sigma * random.normal();
  return M;
}

// Landmarks in an image of EuRoC's size, three patches each.
void Describe(benchmark::State& state) {
  test::Random random(1);
  GrayImage image{.width = 752, .height = 480, .pixels = {}};
  for (int i = 0; i < image.width * image.height; ++i) {
    image.pixels.push_back(static_cast<std::uint8_t>(random.next()));
  }
  std::vector<ImagePatch> patches;
  for (int i = 0; i < state.range(0); ++i) {
    for (const double step : {1.0, 1.4, 2.0}) {
      patches.push_back({.centre = {random.uniform(60, 690), random.uniform(60, 420)},
                         .step = step * Eigen::Matrix2d::Identity()});
    }
  }
  Describer describer;
  for (auto _ : state) benchmark::DoNotOptimize(describer.describe(image, patches));
}
BENCHMARK(Describe)->Arg(30)->Unit(benchmark::kMillisecond);

void JointCompatibility(benchmark::State& state) {
  test::Random random(2);
  const auto m = static_cast<int>(state.range(0));
  const MatrixXd H = random_matrix(random, 2 * m, 6, 1);
  const MatrixXd S = 900 * H * H.transpose() + MatrixXd::Identity(2 * m, 2 * m);
  VectorXd r = 30 * H * random.normal_vector(6) + random.normal_vector(2 * m);
  r.tail(m) = 30 * random.normal_vector(m);  // half of them are wrong
  std::vector<ProposedMatch> proposed;
  for (int i = 0; i < m; ++i) proposed.push_back({.observation = i, .landmark = i});
  for (auto _ : state) benchmark::DoNotOptimize(jointly_compatible(proposed, r, S, 0.99));
}
BENCHMARK(JointCompatibility)->Arg(20)->Arg(40)->Unit(benchmark::kMillisecond);

constexpr Index kState = 250;  // rows: 50 landmarks, 14 clones

// A past with so many landmarks that may return: 20 in each segment.
SegmentChain past(int landmarks) {
  constexpr int kEach = 20;
  test::Random random(3);
  SegmentChain chain;
  for (int first = 0; first < landmarks; first += kEach) {
    Segment segment;
    segment.starts = first == 0 ? 0 : kState;
    for (int i = 0; i < kEach; ++i) segment.items.push_back({.number = first + i, .size = 3});
    const Index q = segment.starts + 3 * kEach;
    segment.X = random_matrix(random, kState, q, 0.05);
    const MatrixXd A = random_matrix(random, q, q, 0.01);
    segment.G = A * A.transpose();
    segment.g = VectorXd::Zero(q);
    chain.append(std::move(segment), [](int) { return true; });
  }
  return chain;
}

std::vector<int> some(int count, int of) {
  std::vector<int> numbers(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) numbers[static_cast<std::size_t>(i)] = i * (of / count);
  return numbers;
}

void Recall25(benchmark::State& state) {
  const auto landmarks = static_cast<int>(state.range(0));
  const SegmentChain chain = past(landmarks);
  const std::vector<int> numbers = some(25, landmarks);
  for (auto _ : state) benchmark::DoNotOptimize(chain.recall(numbers));
}
BENCHMARK(Recall25)->Arg(300)->Arg(750)->Arg(1500)->Unit(benchmark::kMillisecond);

// They pass through all segments.
void Return5(benchmark::State& state) {
  const auto landmarks = static_cast<int>(state.range(0));
  const SegmentChain chain = past(landmarks);
  const std::vector<int> numbers = some(5, landmarks);
  for (auto _ : state) {
    state.PauseTiming();
    SegmentChain copy = chain;
    state.ResumeTiming();
    benchmark::DoNotOptimize(copy.revive(numbers));
  }
}
BENCHMARK(Return5)->Arg(300)->Arg(750)->Arg(1500)->Unit(benchmark::kMillisecond);

LandmarkMap large_map() { return test::corridor_map(4, 10000, 2000, 48); }

void ReadMap(benchmark::State& state) {
  const std::string bytes = map_bytes(large_map());
  for (auto _ : state) benchmark::DoNotOptimize(parse_map(bytes, "map"));
  state.counters["bytes_per_landmark"] = static_cast<double>(bytes.size()) / 10000;
}
BENCHMARK(ReadMap)->Unit(benchmark::kMillisecond);

// 60 landmarks, a fifth of which are in the map.
void FindPlace(benchmark::State& state) {
  const LandmarkMap map = large_map();
  test::Random random(5);
  std::vector<PlacePoint> seen;
  for (int i = 0; i < 60; ++i) {
    const MapPoint& point = map.points[static_cast<std::size_t>(5000 + i)];
    const PatchView& view = point.appearance.views().front();
    seen.push_back({.p_world = point.p_map,
                    .view = i % 5 == 0 ? test::seen_again(random, view, 30)
                                       : test::random_view(random, view.from.cast<double>() * 3)});
  }
  const Eigen::Vector3d p_camera = map.points[4980].p_map;
  for (auto _ : state) benchmark::DoNotOptimize(find_place(seen, p_camera, map));
}
BENCHMARK(FindPlace)->Unit(benchmark::kMillisecond);

// Five of so many landmarks of a prior map return, for the first time.
void ReturnOfMap5(benchmark::State& state) {
  const LandmarkMap map = test::corridor_map(4, static_cast<int>(state.range(0)), 2000, 48);
  std::vector<int> all(map.points.size());
  std::iota(all.begin(), all.end(), 0);
  State x;
  x.v_world = Eigen::Vector3d::Zero();
  x.additive = VectorXd::Zero(6);
  Ekf filter(error_chart("right-sen3"), x, MatrixXd::Identity(15, 15),
             {.map = Ekf::Map::kPast, .past = {.recalls = true}});
  for (int i = 0; i < 40; ++i) filter.clone_pose(i, Time(i));
  MapPlace place;
  place.heading_sigma = 0.3;
  place.position_sigma = 5;
  const int frame = filter.add_past(placed(map, all, place));
  std::vector<int> numbers;
  for (int i = 0; i < 5; ++i) numbers.push_back(frame + 1 + i * 50);
  for (auto _ : state) {
    state.PauseTiming();
    Ekf copy = filter;
    state.ResumeTiming();
    copy.revive(numbers);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(ReturnOfMap5)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace chasles

int main(int argc, char** argv) {
  chasles::dense::prepare();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
