#include <benchmark/benchmark.h>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/segment_chain.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/recognise/appearance.hpp>
#include <chasles/recognise/joint_compatibility.hpp>

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

// The worst case: no landmarks have returned before, and all segments are composed.
void Return5(benchmark::State& state) {
  const auto landmarks = static_cast<int>(state.range(0));
  const SegmentChain chain = past(landmarks);
  const std::vector<int> numbers = some(5, landmarks);
  for (auto _ : state) {
    state.PauseTiming();
    SegmentChain copy = chain;
    state.ResumeTiming();
    benchmark::DoNotOptimize(copy.revive(numbers, [](int) { return true; }));
  }
}
BENCHMARK(Return5)->Arg(300)->Arg(750)->Arg(1500)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace chasles

int main(int argc, char** argv) {
  chasles::dense::prepare();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
