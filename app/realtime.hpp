#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/playback.hpp>

namespace chasles::app {

/// How a run kept up with a recording that was played at its own speed.
struct RealtimeFigures {
  double speed = 1;                  ///< recorded seconds in a second
  Playback::Counts frames = {};      ///< images or frames
  std::vector<double> latency = {};  ///< from a frame's time to its estimate, once running [s]
};

/// The smallest of the values that is not below a fraction p of them; NaN of none.
double quantile(std::vector<double> values, double p);

/// `realtime` of timing.json: speed; frames that came, were dropped; latency_ms with mean, p50, p99
/// and max, null where there was no estimate.
nlohmann::ordered_json realtime_json(const RealtimeFigures& figures);

/// The same for a person: two lines, from realtime_json().
std::string realtime_text(const nlohmann::ordered_json& realtime);

}  // namespace chasles::app
