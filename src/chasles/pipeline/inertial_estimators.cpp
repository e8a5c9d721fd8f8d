#include <algorithm>
#include <deque>
#include <utility>

#include <chasles/pipeline/batch_input.hpp>
#include <chasles/pipeline/estimator.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

// The estimators of visual-inertial runs.
namespace chasles {
namespace {

// Common part: the session that finds the start.
class InertialEstimator : public Estimator {
 public:
  InertialEstimator(const InertialRunSettings& settings, InertialSensors sensors,
                    std::optional<InertialStart> start)
      : settings_(settings),
        sensors_(std::move(sensors)),
        session_(settings.filter, settings.start, sensors_, std::move(start)) {}

  std::vector<Estimate> process(const EstimatorEvent& event) override {
    return std::visit(Overloaded{[&](const ImuSample& sample) { return take(sample); },
                                 [&](const FeatureFrame& frame) { return take(frame); },
                                 // Body velocities are ignored; the IMU measures the motion.
                                 [](const BodyVelocity&) { return std::vector<Estimate>(); }},
                      event);
  }

  bool started() const override { return session_.running(); }
  std::string why_not_started() const override {
    return started() ? std::string()
                     : why_not_initialised(session_.waited(), session_.requirements());
  }
  std::vector<std::string> state_names() const override {
    std::vector<std::string> names;
    for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
      for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(of) + axis);
    }
    return names;
  }
  EstimatorReport report() const override {
    return {.imu = session_.imu_counts(),
            .resets = session_.resets(),
            .dropped_frames = session_.dropped_frames(),
            .batch = {},
            .window = {}};
  }
  void set_observer(InertialSession::OutcomeObserver observer) override {
    session_.set_observer(std::move(observer));
  }

 protected:
  virtual std::vector<Estimate> take(const ImuSample& sample) = 0;
  virtual std::vector<Estimate> take(const FeatureFrame& frame) = 0;

  InertialRunSettings settings_;
  InertialSensors sensors_;
  InertialSession session_;
};

class InertialFilter : public InertialEstimator {
 public:
  using InertialEstimator::InertialEstimator;

  std::vector<Estimate> finish() override { return session_.finish(); }
  std::vector<MapLandmark> map() const override { return session_.map_nav(); }
  std::optional<std::vector<LandmarkId>> in_state() const override { return session_.in_state(); }
  Eigen::Vector3d gyroscope_bias() const override { return session_.gyroscope_bias(); }

 protected:
  std::vector<Estimate> take(const ImuSample& sample) override {
    session_.process(sample);
    return {};
  }
  std::vector<Estimate> take(const FeatureFrame& frame) override { return session_.process(frame); }
};

// The filter, followed by batch estimation with the filter's estimates as initial states.
class InertialBatch : public InertialFilter {
 public:
  using InertialFilter::InertialFilter;

  std::vector<Estimate> finish() override { return keep(InertialFilter::finish()); }

  bool smooths() const override { return true; }
  std::vector<Estimate> smooth() override {
    if (!first_ || result_) return {};
    InertialBatchInput input = batch_input(sensors_, settings_.filter, start_at(*first_));
    input.samples = std::move(samples_);
    input.frames = std::move(frames_);
    input.initial = std::move(initial_);
    result_ = chasles::smooth(input, settings_.filter.chart, settings_.batch);
    return std::exchange(result_->estimates, {});
  }

  std::vector<MapLandmark> map() const override {
    return result_ ? result_->landmarks : InertialFilter::map();
  }
  std::optional<std::vector<LandmarkId>> in_state() const override {
    return result_ ? std::nullopt : InertialFilter::in_state();
  }
  EstimatorReport report() const override {
    EstimatorReport report = InertialFilter::report();
    if (result_) report.batch = result_->report;
    return report;
  }

 protected:
  std::vector<Estimate> take(const ImuSample& sample) override {
    samples_.push_back(sample);
    return InertialFilter::take(sample);
  }
  std::vector<Estimate> take(const FeatureFrame& frame) override {
    frames_.push_back(frame);
    return keep(InertialFilter::take(frame));
  }

 private:
  std::vector<Estimate> keep(std::vector<Estimate> estimates) {
    for (const Estimate& e : estimates) initial_.push_back(timed_motion(e));
    if (!first_ && !estimates.empty()) first_ = estimates.front();
    return estimates;
  }

  std::vector<ImuSample> samples_;
  std::vector<FeatureFrame> frames_;
  std::vector<TimedMotion> initial_;
  std::optional<Estimate> first_;
  std::optional<InertialBatchResult> result_;
};

// The session only finds the start; the window begins there, with all events since.
class InertialWindowEstimator : public InertialEstimator {
 public:
  using InertialEstimator::InertialEstimator;

  std::vector<Estimate> finish() override {
    std::vector<Estimate> estimates;
    if (!window_) {
      const std::vector<Estimate> first = session_.finish();
      if (first.empty()) return {};
      estimates = begin(first.front());
    }
    append(window_->finish(), estimates);
    return estimates;
  }
  void check() const override {
    if (window_) window_->check();
  }

  std::vector<MapLandmark> map() const override {
    return window_ ? window_->map() : session_.map_nav();
  }
  std::optional<std::vector<LandmarkId>> in_state() const override {
    return window_ ? window_->in_window() : session_.in_state();
  }
  Eigen::Vector3d gyroscope_bias() const override {
    return window_ ? window_->gyroscope_bias() : session_.gyroscope_bias();
  }
  EstimatorReport report() const override {
    EstimatorReport report = InertialEstimator::report();
    if (!window_) return report;
    report.window = window_->report();
    report.imu = window_->report().imu;
    report.dropped_frames = window_->report().dropped_frames;
    return report;
  }

 protected:
  std::vector<Estimate> take(const ImuSample& sample) override {
    if (window_) return window_->process(sample);
    session_.process(sample);
    samples_.push_back(sample);
    return {};
  }
  std::vector<Estimate> take(const FeatureFrame& frame) override {
    if (window_) return window_->process(frame);
    frames_.push_back(frame);
    const std::vector<Estimate> first = session_.process(frame);
    if (!first.empty()) return begin(first.front());
    // A frame may carry a damaged time, so the samples limit what it drops.
    const Time now = samples_.empty() ? frame.time : std::min(frame.time, samples_.back().time);
    drop_before(now - from_seconds(2 * settings_.start.max_window));
    return {};
  }

 private:
  // No start uses older data: see InertialSession.
  void drop_before(Time oldest) {
    std::erase_if(frames_, [&](const FeatureFrame& frame) { return frame.time < oldest; });
    while (samples_.size() > 2 && samples_[1].time < oldest) samples_.pop_front();
  }

  // Processes the events until now, in the order of their arrival.
  std::vector<Estimate> begin(const Estimate& first) {
    window_.emplace(batch_input(sensors_, settings_.filter, start_at(first)),
                    settings_.filter.chart, settings_.batch, settings_.estimator.keyframes);
    std::vector<Estimate> estimates;
    auto sample = samples_.begin();
    for (const FeatureFrame& frame : std::exchange(frames_, {})) {
      append(window_->process(frame), estimates);
      for (; sample != samples_.end() && window_->waiting(); ++sample) {
        append(window_->process(*sample), estimates);
      }
    }
    for (; sample != samples_.end(); ++sample) append(window_->process(*sample), estimates);
    samples_.clear();
    return estimates;
  }

  std::deque<ImuSample> samples_;
  std::deque<FeatureFrame> frames_;
  std::optional<InertialWindow> window_;
};

}  // namespace

std::unique_ptr<Estimator> make_estimator(const InertialRunSettings& settings,
                                          InertialSensors sensors,
                                          std::optional<InertialStart> start) {
  validate(settings);
  sensors.pixel_sigma = settings.filter.pixel_sigma.value_or(sensors.pixel_sigma);
  using Kind = EstimatorChoice::Kind;
  switch (settings.estimator.kind) {
    case Kind::kBatch:
      return std::make_unique<InertialBatch>(settings, std::move(sensors), std::move(start));
    case Kind::kWindow:
      return std::make_unique<InertialWindowEstimator>(settings, std::move(sensors),
                                                       std::move(start));
    case Kind::kFilter:
      break;
  }
  return std::make_unique<InertialFilter>(settings, std::move(sensors), std::move(start));
}

}  // namespace chasles
