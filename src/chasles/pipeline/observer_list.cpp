#include <algorithm>

#include <chasles/pipeline/observer_list.hpp>

namespace chasles {

bool ObserverList::stop() {
  return std::ranges::any_of(observers_, [](RunObserver& one) { return one.stop(); });
}

void ObserverList::on_images(const ImageFrame& images) {
  for (RunObserver& one : observers_) one.on_images(images);
}

void ObserverList::on_unreadable(const InputError& error) {
  for (RunObserver& one : observers_) one.on_unreadable(error);
}

void ObserverList::on_frame(const FeatureFrame& frame) {
  for (RunObserver& one : observers_) one.on_frame(frame);
}

void ObserverList::on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) {
  for (RunObserver& one : observers_) one.on_outcomes(frame, outcomes);
}

void ObserverList::on_estimate(const Estimate& estimate, const EstimateTiming& timing) {
  for (RunObserver& one : observers_) one.on_estimate(estimate, timing);
}

void ObserverList::on_progress(std::size_t frames, Time now) {
  for (RunObserver& one : observers_) one.on_progress(frames, now);
}

void ObserverList::on_smoothing() {
  for (RunObserver& one : observers_) one.on_smoothing();
}

void ObserverList::on_smoothed(std::span<const Estimate> estimates, double seconds) {
  for (RunObserver& one : observers_) one.on_smoothed(estimates, seconds);
}

}  // namespace chasles
