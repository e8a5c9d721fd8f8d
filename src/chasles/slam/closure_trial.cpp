#include <algorithm>
#include <chrono>
#include <utility>

#include <chasles/slam/closure_trial.hpp>

namespace chasles {
namespace {

constexpr Time kDuration = std::chrono::seconds(2);
// Closures that follow each other are on trial together, for no longer than this.
constexpr Time kLongest = std::chrono::seconds(5);
constexpr std::size_t kLeastRejected = 3;

}  // namespace

std::optional<Estimate> ClosureTrial::assess(const FeatureFrame& frame,
                                             std::unique_ptr<InertialSlam>& slam) {
  if (auto without = slam->take_without()) {
    if (!without_) {
      without_ = std::move(without);
      closures_before_ = without_->loops().closures().size();
    }
    returned_.insert(returned_.end(), slam->loops().returned().begin(),
                     slam->loops().returned().end());
    until_ = frame.time + kDuration;
  }
  if (!without_) return std::nullopt;
  frames_.push_back(frame);
  for (const LandmarkId id : slam->loops().rejected()) {
    if (std::ranges::find(returned_, id) != returned_.end()) ++rejected_;
  }
  if (rejected_ >= kLeastRejected && 2 * rejected_ > returned_.size()) return undo(slam);
  if (frame.time >= until_ || frame.time - frames_.front().time >= kLongest) end();
  return std::nullopt;
}

Estimate ClosureTrial::undo(std::unique_ptr<InertialSlam>& slam) {
  const std::vector<Closure> undone(
      slam->loops().closures().begin() + static_cast<std::ptrdiff_t>(closures_before_),
      slam->loops().closures().end());
  slam = std::make_unique<InertialSlam>(std::move(*without_));
  Estimate e = slam->conclude(frames_.front());
  for (std::size_t i = 1; i < frames_.size(); ++i) e = slam->process(frames_[i]);
  slam->note_undone(undone);
  end();
  return e;
}

void ClosureTrial::end() {
  without_.reset();
  frames_.clear();
  returned_.clear();
  rejected_ = 0;
}

}  // namespace chasles
