#include <algorithm>
#include <cmath>

#include <chasles/imu/vibration_noise.hpp>

namespace chasles {
namespace {

constexpr Time kBlock = std::chrono::milliseconds(100);
// Over a longer interval between two samples the signal has changed by its own motion.
constexpr Time kLongestInterval = std::chrono::milliseconds(50);
constexpr int kAxes = 3;

std::int64_t block_number(Time time) {
  const std::int64_t number = time / kBlock;
  return time < number * kBlock ? number - 1 : number;  // rounded down, before the epoch too
}

}  // namespace

AddedNoise VibrationNoise::add(const ImuSample& sample, Unusable unusable) {
  return {.accelerometer = force_.add(sample.time, sample.specific_force_imu, !unusable.force),
          .gyroscope = rate_.add(sample.time, sample.angular_rate_imu, !unusable.rate)};
}

std::size_t VibrationNoise::Signal::place(std::int64_t number) {
  const auto blocks = static_cast<std::int64_t>(kBlocks);
  return static_cast<std::size_t>((number % blocks + blocks) % blocks);
}

VibrationNoise::Block& VibrationNoise::Signal::block_at(Time time) {
  const std::int64_t number = block_number(time);
  Block& block = blocks_[place(number)];
  if (block.number != number) block = {.number = number};
  return block;
}

void VibrationNoise::Signal::note(const Recent& now, Block& block) {
  ++block.samples;
  block.sum += now.value;
  block.squares += now.value.squaredNorm();
  if (count_ > 0 && now.time - recent_[0].time > kLongestInterval) count_ = 0;
  std::ranges::copy_backward(recent_.begin(), recent_.end() - 1, recent_.end());
  recent_[0] = now;
  count_ = std::min(count_ + 1, static_cast<int>(recent_.size()));
  if (count_ < static_cast<int>(recent_.size())) return;
  const auto& [x0, x1, x2, x3] = recent_;
  const double square = (x0.value + x1.value - x2.value - x3.value).squaredNorm() / 4;
  // The mean interval: stamps may jitter where the sampling does not.
  const double dt = to_seconds(x0.time - x3.time) / 3;
  ++block.differences;
  block.difference2 += square;
  block.difference2_time += square * dt;
}

double VibrationNoise::Signal::density(std::int64_t number) const {
  Block all;
  for (auto n = number - static_cast<std::int64_t>(kBlocks) + 1; n <= number; ++n) {
    const Block& block = blocks_[place(n)];
    if (block.number != n) continue;
    all.samples += block.samples;
    all.differences += block.differences;
    all.sum += block.sum;
    all.squares += block.squares;
    all.difference2 += block.difference2;
    all.difference2_time += block.difference2_time;
  }
  if (all.differences == 0) return 0;
  const double samples = all.samples, values = kAxes * static_cast<double>(all.differences);
  const double variance = (all.squares - all.sum.squaredNorm() / samples) / (kAxes * samples);
  const double slow = std::max(0.0, variance - all.difference2 / values);
  const auto square = [](double x) { return x * x; };
  return std::sqrt(square(constants_.vibration) * all.difference2_time / values +
                   square(constants_.motion) * slow);
}

double VibrationNoise::Signal::add(Time time, const Eigen::Vector3d& value, bool usable) {
  if (usable) {
    note({.time = time, .value = value}, block_at(time));
  } else {
    count_ = 0;  // the differences begin again
  }
  return density(block_number(time));
}

}  // namespace chasles
