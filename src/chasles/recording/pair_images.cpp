#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/recording/pair_images.hpp>

namespace chasles {
namespace {

struct CameraPairs {
  std::size_t found = 0;              // images that belong to a frame
  Time nearest = Time::max();         // of the others to a frame
  std::vector<std::size_t> far = {};  // images that are near no frame
};

// The images of a camera join the frames. Both lists rise, and each image joins the nearest frame.
CameraPairs join(const std::vector<Time>& stamps, std::size_t camera, Time tolerance,
                 std::vector<PairedFrame>& frames) {
  CameraPairs pairs;
  std::size_t f = 0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const auto distance = [&](std::size_t k) {
      return std::chrono::abs(frames[k].time - stamps[i]);
    };
    while (f + 1 < frames.size() && distance(f + 1) < distance(f)) ++f;
    if (frames.empty() || distance(f) > tolerance) {
      if (!frames.empty()) pairs.nearest = std::min(pairs.nearest, distance(f));
      pairs.far.push_back(i);
      continue;
    }
    std::optional<std::size_t>& member = frames[f].members[camera];
    if (member && std::chrono::abs(stamps[*member] - frames[f].time) <= distance(f)) continue;
    if (!member) ++pairs.found;
    member = i;
  }
  return pairs;
}

void add_frames(const std::vector<Time>& stamps, std::size_t camera,
                const std::vector<std::size_t>& images, std::vector<PairedFrame>& frames) {
  const std::size_t cameras = frames.front().members.size();
  for (const std::size_t i : images) {
    frames.push_back({.time = stamps[i], .members = {}});
    frames.back().members.resize(cameras);
    frames.back().members[camera] = i;
  }
  std::ranges::stable_sort(frames, {}, &PairedFrame::time);
}

std::string remark_on_own_frames(std::size_t camera, std::size_t images, const CameraPairs& pairs) {
  return fmt::format(
      "{} of the {} images of cam{} are at other instants than those of the cameras before it, by "
      "at least {:.1f} ms: they are frames of their own",
      pairs.far.size(), images, camera, 1e3 * to_seconds(pairs.nearest));
}

std::string remark(std::size_t camera, std::size_t images, std::size_t frames,
                   const CameraPairs& pairs, Time tolerance) {
  const auto milliseconds = [](Time time) { return 1e3 * to_seconds(time); };
  if (pairs.found > 0) {
    std::string text = fmt::format("cam{} has an image for {} of the {} frames of cam0", camera,
                                   pairs.found, frames);
    if (pairs.found == images) return text;
    return text + fmt::format("; {} of its images are more than {:g} ms from all of them: left out",
                              images - pairs.found, milliseconds(tolerance));
  }
  return fmt::format(
      "cam{} is not used: none of its {} images is within {:g} ms of one of cam0, the nearest is "
      "{:.1f} ms off; trigger the cameras together, or state the shift of their clocks "
      "(timeshift_cam_imu)",
      camera, images, milliseconds(tolerance), milliseconds(pairs.nearest));
}

}  // namespace

std::vector<PairedFrame> pair_images(const std::vector<std::vector<Time>>& stamps,
                                     const std::vector<bool>& finders, Time tolerance,
                                     std::vector<std::string>& remarks) {
  std::vector<PairedFrame> frames;
  for (std::size_t i = 0; i < stamps[0].size(); ++i) {
    frames.push_back({.time = stamps[0][i], .members = {}});
    frames.back().members.resize(stamps.size());
    frames.back().members[0] = i;
  }
  for (std::size_t c = 1; c < stamps.size(); ++c) {
    const CameraPairs pairs = join(stamps[c], c, tolerance, frames);
    if (stamps[c].empty() || (pairs.found == frames.size() && pairs.found == stamps[c].size())) {
      continue;
    }
    if (finders[c] && !pairs.far.empty()) {
      remarks.push_back(remark_on_own_frames(c, stamps[c].size(), pairs));
      add_frames(stamps[c], c, pairs.far, frames);
      continue;
    }
    remarks.push_back(remark(c, stamps[c].size(), frames.size(), pairs, tolerance));
  }
  return frames;
}

}  // namespace chasles
