#include "export_times.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/time_text.hpp>
#include <chasles/reconstruct/predicted_path.hpp>
#include <chasles/reconstruct/recording_of_run.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/at_times.hpp>
#include <chasles/session/inertial_settings_io.hpp>

namespace chasles::app {
namespace {

constexpr double kMostHertz = 1e5;

// The rows but for comments and a head.
std::vector<std::string_view> first_column(std::string_view text) {
  std::vector<std::string_view> texts;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, line.find_first_of(" \t,;\r"));
    const bool is_head = texts.empty() && !line.empty() &&
                         std::isalpha(static_cast<unsigned char>(line.front())) != 0;
    if (!line.empty() && line.front() != '#' && !is_head) texts.push_back(line);
  }
  return texts;
}

std::vector<Time> times_of_file(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  const std::vector<std::string_view> texts = first_column(text);
  if (texts.empty()) {
    throw InputError(
        fmt::format("{}: has no times, expected one in each line, in seconds with "
                    "decimals or in whole nanoseconds",
                    file.string()));
  }
  std::vector<Time> times = read_unscaled_times(texts, [&](std::size_t i) {
                              return fmt::format("{}: time {}", file.string(), i + 1);
                            }).times;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) continue;
    throw InputError(
        fmt::format("{}: time {} is not later than the one before, expected times "
                    "that rise",
                    file.string(), i + 1));
  }
  return times;
}

std::vector<Time> regular_times(const Run& run, const std::string& rate) {
  double hertz = 0;
  const char* const end = rate.data() + rate.size();
  const auto [rest, error] = std::from_chars(rate.data(), end, hertz);
  if (error != std::errc{} || rest != end || !(hertz > 0) || hertz > kMostHertz) {
    throw UsageError(
        fmt::format("--rate: found '{}', expected imu, or a number of Hz above 0 and at most {}",
                    rate, kMostHertz));
  }
  std::vector<Time> times;
  if (run.states.empty()) return times;
  const Time first = run.states.front().time, last = run.states.back().time;
  for (Time time = first; time <= last;
       time = first + from_seconds(static_cast<double>(times.size()) / hertz)) {
    times.push_back(time);
  }
  return times;
}

template <typename Row>
std::vector<Row> known_rows(const std::vector<RowAt<Row>>& at) {
  std::vector<Row> rows;
  for (const RowAt<Row>& one : at) {
    if (one.known) rows.push_back(one.row);
  }
  return rows;
}

std::string interpolate(const std::vector<Time>& times, const ExportChoice& choice, Run& run) {
  std::vector<RunState> states = known_rows(states_at(run, times));
  std::vector<SmoothedPose> smoothed = known_rows(smoothed_at(run, times));
  const bool is_smoothed = choice.path == RunPath::kSmoothed;
  const std::size_t known = is_smoothed ? smoothed.size() : states.size();
  // A path that is missing is the error of the format.
  const bool has_path = is_smoothed ? !run.smoothed.empty() : !run.states.empty();
  if (known == 0 && has_path) {
    throw InputError(fmt::format(
        "run '{}': at none of the {} times is a state known, expected times within its path, which "
        "is from {} to {} s",
        run.name, times.size(), seconds_text(run.states.front().time),
        seconds_text(run.states.back().time)));
  }
  run.states = std::move(states);
  run.smoothed = std::move(smoothed);
  return fmt::format("states at {} of {} times, interpolated; at the others the run has none",
                     known, times.size());
}

std::string predict(const ExportChoice& choice, ReportRun& run) {
  if (choice.path == RunPath::kSmoothed) {
    throw UsageError(
        "--rate imu: the smoothed path has no velocities and biases to predict from, expected a "
        "number of Hz, or no --smoothed");
  }
  if (choice.recording.empty()) {
    throw UsageError("--rate imu: expected --recording with the IMU's samples");
  }
  const InertialRunSettings settings = inertial_run_settings_of(run.summary);
  const Recording recording = as_in_run(read_recording(choice.recording), run.summary, settings);
  PredictedPath path = predicted_path(run.run, recording, settings);
  if (path.run.states.empty()) {
    throw InputError(fmt::format(
        "run '{}': none of the samples of {} is within its path, expected its recording",
        run.run.name, choice.recording.string()));
  }
  run.run = std::move(path.run);
  return fmt::format(
      "states at {} samples of the IMU, predicted from the state before; at {} there is none",
      run.run.states.size(), path.without);
}

}  // namespace

std::string states_at_times(const ExportTimes& times, const ExportChoice& choice, ReportRun& run) {
  if (!times.file.empty() && !times.rate.empty()) {
    throw UsageError("--times and --rate: found both, expected one of them");
  }
  if (times.rate == "imu") return predict(choice, run);
  return interpolate(
      times.file.empty() ? regular_times(run.run, times.rate) : times_of_file(times.file), choice,
      run.run);
}

}  // namespace chasles::app
