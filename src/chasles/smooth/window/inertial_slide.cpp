#include <algorithm>
#include <iterator>

#include <chasles/base/interruption.hpp>
#include <chasles/imu/sample_screen.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

namespace chasles {

InertialWindowResult slide(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings, int keyframes) {
  InertialWindow window(input, chart, settings, keyframes);
  InertialWindowResult result;
  const auto keep = [&](std::vector<Estimate> some) {
    std::ranges::move(some, std::back_inserter(result.estimates));
  };
  SampleScreen screen(input.imu.range());
  auto sample = input.samples.begin();
  for (const FeatureFrame& frame : input.frames) {
    interruption_point();
    keep(window.process(frame));
    for (; sample != input.samples.end() && window.waiting(); ++sample) {
      for (const ImuSample& measured : screen.add(*sample)) keep(window.process(measured));
    }
  }
  keep(window.finish());
  window.check();
  result.landmarks = window.map();
  result.in_window = window.in_window();
  result.report = window.report();
  result.report.imu.note(screen.counts());
  return result;
}

}  // namespace chasles
