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
      : settings_(settings), sensors_(sensors) {}

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
  std::vector<std::string> state_names() const override {
    return additive_names(model_of(settings_.filter, sensors_.noise));
  }
  bool ended() const override { return lost_; }
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

  std::vector<MapLandmark> map() const override { return slam_.filter().map(); }
  Past::Estimates past() const override { return slam_.filter().past_estimates(); }
  std::optional<std::vector<LandmarkId>> in_state() const override {
    std::vector<LandmarkId> ids;
    for (const Landmark& l : slam_.filter().state().landmarks) ids.push_back(l.id);
    return ids;
  }
  std::span<const MapLandmark> initial_landmarks() const override {
    return slam_.initial_landmarks();
  }
  const Ekf* filter() const override { return &slam_.filter(); }

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

  bool ended() const override { return false; }  // batch estimation uses the whole recording
  const Ekf* filter() const override { return nullptr; }

  std::vector<Estimate> process(const EstimatorEvent& event) override {
    if (const auto* velocity = std::get_if<BodyVelocity>(&event)) velocities_.push_back(*velocity);
    if (const auto* frame = std::get_if<FeatureFrame>(&event)) frames_.push_back(*frame);
    std::vector<Estimate> estimates = VelocityFilter::process(event);
    initial_.insert(initial_.end(), estimates.begin(), estimates.end());
    return estimates;
  }

  bool smooths() const override { return true; }
  std::vector<Estimate> smooth(const StopRequest& stop) override {
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
  std::vector<MapLandmark> map() const override {
    return result_ ? result_->landmarks : VelocityFilter::map();
  }
  Past::Estimates past() const override {
    return result_ ? Estimator::past() : VelocityFilter::past();
  }
  std::span<const MapLandmark> initial_landmarks() const override { return {}; }
  std::optional<std::vector<LandmarkId>> in_state() const override {
    return result_ ? std::nullopt : VelocityFilter::in_state();
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

  void check() const override { window_.check(); }
  std::vector<MapLandmark> map() const override { return window_.map(); }
  std::optional<std::vector<LandmarkId>> in_state() const override { return window_.in_window(); }
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

}  // namespace chasles
