#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/playback.hpp>

namespace chasles {

/// Dropped frames and latency of a run that played the recording in real time.
struct RealtimeFigures {
  double speed = 1;                  ///< recorded seconds per second
  Playback::Counts frames = {};      ///< images or frames
  std::vector<double> latency = {};  ///< from a frame's time to its estimate [s], after the start
};

/// The p-quantile: the smallest value that is not below a fraction p of all values. NaN if empty.
double quantile(std::vector<double> values, double p);

/// The object `realtime` of timing.json: speed, received and dropped frames, and latency_ms with
/// mean, p50, p99 and max. The latencies are null if there was no estimate.
nlohmann::ordered_json realtime_json(const RealtimeFigures& figures);

/// The figures of realtime_json() as two lines of text.
std::string realtime_text(const nlohmann::ordered_json& realtime);

}  // namespace chasles
