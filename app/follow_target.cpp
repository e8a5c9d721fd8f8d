#include "follow_target.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/live_motion.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/target/target_file.hpp>

#include "live_text.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kSentences = 3;  // of what is missing
constexpr std::chrono::milliseconds kPollInterval{100};
constexpr std::chrono::seconds kBetweenTexts{1}, kSilence{5};

void check_folder(const ViewsOptions& o) {
  std::error_code ignored;
  if (o.recordings.size() != 1) {
    throw UsageError(fmt::format("--live: found {} recordings, expected one folder of images",
                                 o.recordings.size()));
  }
  const fs::path& path = o.recordings.front();
  if (fs::exists(path, ignored) && !fs::is_directory(path, ignored)) {
    throw UsageError(fmt::format(
        "--live: {} is a file, expected a folder to which another program writes images (cam0/, "
        "cam1/, ...); chasles.CaptureGuide in Python takes images from anywhere",
        path.string()));
  }
}

// `motion`: null where there is no IMU.
std::vector<std::string> lines_of(const LiveCapture& capture, const LiveMotion* motion,
                                  const fs::path& folder, Clock::duration silence) {
  std::vector<std::string> missing = capture.missing();
  if (motion) {
    const auto [first, last] = capture.span();
    std::ranges::move(motion->missing(first, last), std::back_inserter(missing));
  }
  std::vector<std::string> lines;
  if (!capture.seen().empty()) lines.push_back(capture.seen() + "; " + capture.found());
  if (missing.empty()) lines.push_back("enough: press Ctrl-C");
  for (std::size_t i = 0; i < std::min(missing.size(), kSentences); ++i)
    lines.push_back(missing[i]);
  if (missing.size() > kSentences)
    lines.push_back(fmt::format("and {} more", missing.size() - kSentences));
  if (silence >= kSilence) {
    lines.push_back(
        fmt::format("no new image in {} for {} s or more: waiting; Ctrl-C ends and calibrates",
                    folder.string(), kSilence.count()));
  }
  return lines;
}

}  // namespace

std::unique_ptr<LiveCapture> follow_target(ViewsOptions& o) {
  if (!o.live) return nullptr;
  check_folder(o);
  const fs::path& folder = o.recordings.front();
  const Target target = read_target(o.target);
  auto capture = std::make_unique<LiveCapture>(folder, target, candidate_lenses(o));
  std::optional<LiveMotion> motion;
  if (o.follows_target) motion.emplace(folder);
  const Interrupt ended;
  {
    LiveText text(o.quiet);
    Clock::time_point next_text = Clock::now(), next_poll = next_text, newest = next_text;
    std::size_t recorded = 0;
    while (!ended.requested()) {
      if (Clock::now() >= next_poll) {
        capture->poll();
        next_poll = Clock::now() + kPollInterval;
      }
      const bool has_searched = capture->search();
      check_symmetry(o, target, capture->cameras());
      const Clock::time_point now = Clock::now();
      if (capture->recorded() > recorded) newest = now;
      recorded = capture->recorded();
      if (now >= next_text) {
        if (motion) motion->poll();
        text.show(lines_of(*capture, motion ? &*motion : nullptr, folder, now - newest));
        next_text = now + kBetweenTexts;
      }
      if (!has_searched) std::this_thread::sleep_until(next_poll);
    }
  }
  if (!o.quiet && capture->skipped() > 0) {
    app::note("{} of {} images were skipped while they were recorded: they are searched now\n",
              capture->skipped(), capture->recorded());
  }
  o.known = [&images = *capture](const fs::path& file) { return images.known(file); };
  return capture;
}

}  // namespace chasles::app
