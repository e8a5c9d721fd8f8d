#include <utility>

#include <chasles/pipeline/estimator.hpp>
#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/smooth/window/velocity_window.hpp>
#include <chasles/velocity/velocity_model.hpp>
#include <chasles/velocity/velocity_slam.hpp>

// The estimators of stereo-velocity runs.
namespace chasles {
namespace {

class VelocityEstimator : public Estimator {
 public:
  VelocityEstimator(const VelocityRunSettings& settings, const VelocitySensors& sensors)
      : Estimator(additive_names(model_of(settings.filter, sensors.noise))),
        settings_(settings),
        sensors_(sensors) {}

  // After the estimate is lost, events are ignored: arithmetic with values that are not finite is
  // slow, and all later estimates are meaningless.
  std::vector<Estimate> process(const EstimatorEvent& event) override {
    if (lost_) return {};
    return std::visit(Overloaded{[&](const BodyVelocity& velocity) {
                                   take(velocity);
                                   return std::vector<Estimate>();
                                 },
                                 [&](const FeatureFrame& frame) {
                                   std::vector<Estimate> estimates = take(frame);
                                   for (const Estimate& e : estimates) {
                                     lost_ = e.health == Health::kLost;
                                   }
                                   return estimates;
                                 },
                                 // IMU samples are ignored; the body velocities measure the motion.
                                 [](const ImuSample&) { return std::vector<Estimate>(); }},
                      event);
  }
  EstimatorStatus status() const override { return {.ended = lost_}; }
  EstimatorReport report() const override { return {}; }

 protected:
  virtual void take(const BodyVelocity& velocity) = 0;
  virtual std::vector<Estimate> take(const FeatureFrame& frame) = 0;

  VelocityBatchInput input() const {
    return {.rig = sensors_.rig,
            .settings = settings_.filter,
            .noise = sensors_.noise,
            .velocities = {},
            .frames = {}};
  }

  VelocityRunSettings settings_;
  VelocitySensors sensors_;

 private:
  bool lost_ = false;
};

class VelocityFilter : public VelocityEstimator {
 public:
  VelocityFilter(const VelocityRunSettings& settings, const VelocitySensors& sensors)
      : VelocityEstimator(settings, sensors), slam_(settings.filter, sensors.rig, sensors.noise) {}

  EstimatedMap whole_map() const override {
    Past::Estimates past = slam_.filter().past().estimates();
    const auto initial = slam_.initial_landmarks();
    EstimatedMap map{.landmarks = std::move(past.landmarks),
                     .poses = std::move(past.poses),
                     .initial = {initial.begin(), initial.end()},
                     .in_state = std::vector<LandmarkId>()};
    for (const Landmark& l : slam_.filter().state().landmarks) map.in_state->push_back(l.id);
    return map;
  }
  const Ekf& filter() const { return slam_.filter(); }

 protected:
  void take(const BodyVelocity& velocity) override { slam_.process(velocity); }
  std::vector<Estimate> take(const FeatureFrame& frame) override { return {slam_.process(frame)}; }

 private:
  VelocitySlam slam_;
};

// The filter, followed by batch estimation with the filter's estimates as initial states.
class VelocityBatch : public VelocityFilter {
 public:
  using VelocityFilter::VelocityFilter;

  // Batch estimation uses the whole recording, also where the filter is lost.
  EstimatorStatus status() const override { return {.smooths = true}; }

  std::vector<Estimate> process(const EstimatorEvent& event) override {
    if (const auto* velocity = std::get_if<BodyVelocity>(&event)) velocities_.push_back(*velocity);
    if (const auto* frame = std::get_if<FeatureFrame>(&event)) frames_.push_back(*frame);
    std::vector<Estimate> estimates = VelocityFilter::process(event);
    initial_.insert(initial_.end(), estimates.begin(), estimates.end());
    return estimates;
  }

  std::vector<Estimate> complete(const StopRequest& stop) override {
    if (result_) return {};
    VelocityBatchInput in = input();
    in.velocities = std::move(velocities_);
    in.frames = std::move(frames_);
    in.initial = std::move(initial_);
    try {
      result_ = chasles::smooth(in, settings_.batch, stop);
    } catch (const BatchStopped&) {
      return {};
    }
    return std::exchange(result_->estimates, {});
  }
  EstimatedMap whole_map() const override {
    if (result_) return {.landmarks = result_->landmarks};
    EstimatedMap map = VelocityFilter::whole_map();
    map.initial.clear();
    return map;
  }
  EstimatorReport report() const override {
    EstimatorReport report;
    if (result_) report.batch = result_->report;
    return report;
  }

 private:
  std::vector<BodyVelocity> velocities_;
  std::vector<FeatureFrame> frames_;
  std::vector<Estimate> initial_;
  std::optional<VelocityBatchResult> result_;
};

class VelocityWindowEstimator : public VelocityEstimator {
 public:
  VelocityWindowEstimator(const VelocityRunSettings& settings, const VelocitySensors& sensors)
      : VelocityEstimator(settings, sensors),
        window_(input(), settings.batch, settings.estimator.keyframes) {}

  std::vector<Estimate> complete(const StopRequest& /*stop*/) override {
    window_.check();
    return {};
  }
  EstimatedMap whole_map() const override {
    return {.landmarks = window_.map(), .in_state = window_.in_window()};
  }
  EstimatorReport report() const override {
    EstimatorReport report;
    report.window = window_.report();
    return report;
  }

 protected:
  void take(const BodyVelocity& velocity) override { window_.process(velocity); }
  std::vector<Estimate> take(const FeatureFrame& frame) override {
    std::optional<Estimate> e = window_.process(frame);
    return e ? std::vector{std::move(*e)} : std::vector<Estimate>();
  }

 private:
  VelocityWindow window_;
};

}  // namespace

std::unique_ptr<Estimator> make_estimator(const VelocityRunSettings& settings,
                                          const VelocitySensors& sensors) {
  validate(settings);
  using Kind = EstimatorChoice::Kind;
  switch (settings.estimator.kind) {
    case Kind::kBatch:
      return std::make_unique<VelocityBatch>(settings, sensors);
    case Kind::kWindow:
      return std::make_unique<VelocityWindowEstimator>(settings, sensors);
    case Kind::kFilter:
      break;
  }
  return std::make_unique<VelocityFilter>(settings, sensors);
}

const Ekf* filter_with_joint_map(const Estimator& estimator) {
  if (dynamic_cast<const VelocityBatch*>(&estimator) != nullptr) return nullptr;
  const auto* filter = dynamic_cast<const VelocityFilter*>(&estimator);
  return filter != nullptr ? &filter->filter() : nullptr;
}

}  // namespace chasles
