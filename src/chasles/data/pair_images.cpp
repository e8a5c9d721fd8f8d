#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/pair_images.hpp>

namespace chasles {
namespace {

// Combines the earliest remaining images, one per camera, into one frame.
std::optional<PairedFrame> next_frame(const std::vector<std::vector<Time>>& stamps,
                                      std::vector<std::size_t>& taken, Time tolerance) {
  Time first = Time::max();
  for (std::size_t c = 0; c < stamps.size(); ++c) {
    if (taken[c] < stamps[c].size()) first = std::min(first, stamps[c][taken[c]]);
  }
  if (first == Time::max()) return std::nullopt;
  PairedFrame frame{.time = Time::max(), .members = {}};
  frame.members.resize(stamps.size());
  for (std::size_t c = 0; c < stamps.size(); ++c) {
    if (taken[c] == stamps[c].size() || stamps[c][taken[c]] - first > tolerance) continue;
    if (frame.time == Time::max()) frame.time = stamps[c][taken[c]];
    frame.members[c] = taken[c]++;
  }
  return frame;
}

}  // namespace

std::vector<PairedFrame> pair_images(const std::vector<std::vector<Time>>& stamps, Time tolerance,
                                     std::vector<std::string>& remarks) {
  std::vector<std::size_t> taken(stamps.size());
  std::vector<PairedFrame> frames;
  std::size_t incomplete = 0, between = 0;
  while (auto frame = next_frame(stamps, taken, tolerance)) {
    if (!frames.empty() && frame->time <= frames.back().time) {
      ++between;
      continue;
    }
    incomplete +=
        std::count(frame->members.begin(), frame->members.end(), std::nullopt) > 0 ? 1 : 0;
    frames.push_back(std::move(*frame));
  }
  if (incomplete > 0) {
    remarks.push_back(fmt::format("{} of {} frames have an image of only some of the {} cameras",
                                  incomplete, frames.size(), stamps.size()));
  }
  if (between > 0) {
    remarks.push_back(
        fmt::format("{} images lie between those of another frame: left out", between));
  }
  return frames;
}

}  // namespace chasles
