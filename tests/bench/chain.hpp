#pragma once

#include <vector>

#include <chasles/base/processor_time.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/pipeline/run_settings.hpp>
#include <chasles/recording/recording.hpp>

// From pixels to the estimate on one thread, with images in memory.
namespace chasles::bench {

/// Processor time of all threads; a benchmark has one [ms].
inline double cpu_ms() { return 1e3 * process_seconds(); }

struct Footage {
  Recording recording;
  std::vector<ImageFrame> frames;
};

/// All images of a recording, read.
Footage footage_of(Recording recording);

/// Of a frame: processor time [ms], and its work.
struct Cost {
  double frontend = 0, filter = 0;
  FrontendReport report = {};
  Estimate estimate = {};
  double all() const { return frontend + filter; }
};

/// The cost of each frame after the initialisation, with the first cameras of the recording.
std::vector<Cost> chain(const Footage& footage, std::size_t cameras,
                        const InertialRunSettings& settings);

/// The minimum of the repetitions, frame by frame.
void keep_least(const std::vector<Cost>& more, std::vector<Cost>& least);

}  // namespace chasles::bench
