#include "follow_target.hpp"

#include <chrono>
#include <filesystem>
#include <thread>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/target/target_file.hpp>

#include "live_text.hpp"
#include "print.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kBetweenLooks{100};
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

std::vector<std::string> text_of(const LiveCapture& capture, const fs::path& folder,
                                 Clock::duration silence) {
  const std::vector<std::string> missing = capture.missing();
  std::vector<std::string> lines;
  if (!capture.seen().empty()) lines.push_back(capture.seen() + "; " + capture.found());
  lines.push_back(missing.empty() ? "enough: press Ctrl-C" : missing.front());
  if (missing.size() > 1) lines.back() += fmt::format(" (and {} more)", missing.size() - 1);
  if (silence >= kSilence) {
    lines.push_back(
        fmt::format("no new image in {} for {} s or more: waiting; Ctrl-C ends and calibrates",
                    folder.string(), kSilence.count()));
  }
  return lines;
}

}  // namespace

std::unique_ptr<LiveCapture> follow_target(const ViewsOptions& o) {
  check_folder(o);
  const fs::path& folder = o.recordings.front();
  const Target target = read_target(o.target);
  auto capture = std::make_unique<LiveCapture>(folder, target, candidate_lenses(o));
  const Interrupt ended;
  {
    LiveText text(o.quiet);
    Clock::time_point next_text = Clock::now(), newest = next_text;
    std::size_t recorded = 0;
    while (!ended.requested()) {
      const bool has_searched = capture->step();
      check_symmetry(o, target, capture->cameras());
      const Clock::time_point now = Clock::now();
      if (capture->recorded() > recorded) newest = now;
      recorded = capture->recorded();
      if (now >= next_text) {
        text.show(text_of(*capture, folder, now - newest));
        next_text = now + kBetweenTexts;
      }
      if (!has_searched) std::this_thread::sleep_for(kBetweenLooks);
    }
  }
  const std::size_t skipped = capture->recorded() - capture->searched();
  if (!o.quiet && skipped > 0) {
    app::note("{} of {} images were skipped while they were recorded: they are searched now\n",
              skipped, capture->recorded());
  }
  return capture;
}

}  // namespace chasles::app
