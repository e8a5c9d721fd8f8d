#pragma once

#include <functional>
#include <initializer_list>
#include <vector>

#include <chasles/pipeline/run.hpp>

namespace chasles {

/// Several observers as one. Each call reaches all of them, in their order; the run stops where one
/// of them stops it.
class ObserverList : public RunObserver {
 public:
  /// They must outlive the list.
  ObserverList(std::initializer_list<std::reference_wrapper<RunObserver>> observers)
      : observers_(observers) {}

  bool stop() override;
  void on_images(const ImageFrame& images) override;
  void on_unreadable(const InputError& error) override;
  void on_frame(const FeatureFrame& frame) override;
  void on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) override;
  void on_estimate(const Estimate& estimate, const EstimateTiming& timing) override;
  void on_progress(std::size_t frames, Time now) override;
  void on_smoothing() override;
  void on_smoothed(std::span<const Estimate> estimates, double seconds) override;

 private:
  std::vector<std::reference_wrapper<RunObserver>> observers_;
};

}  // namespace chasles
