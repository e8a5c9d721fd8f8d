#include <algorithm>
#include <deque>
#include <map>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/imu/sample_screen.hpp>
#include <chasles/imu/time_gaps.hpp>
#include <chasles/pipeline/batch_input.hpp>
#include <chasles/pipeline/batch_parts.hpp>
#include <chasles/pipeline/estimator.hpp>
#include <chasles/slam/waiting_samples.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

// The estimators of visual-inertial runs.
namespace chasles {
namespace {

std::vector<std::string> names_of_states() {
  std::vector<std::string> names;
  for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(of) + axis);
  }
  return names;
}

InertialSensors behind_a_screen(InertialSensors sensors) {
  sensors.imu.screened = true;
  return sensors;
}

// Common part: the door of the samples, and the session that finds the start. Everything behind
// the door takes measurements only.
class InertialEstimator : public Estimator {
 public:
  InertialEstimator(const InertialRunSettings& settings, InertialSensors sensors,
                    std::optional<InertialStart> start,
                    std::shared_ptr<const LandmarkMap> prior = nullptr)
      : Estimator(names_of_states()),
        settings_(settings),
        sensors_(behind_a_screen(std::move(sensors))),
        screen_(sensors_.imu.range()),
        session_(settings.filter, settings.start, sensors_, std::move(start), std::move(prior)) {
    session_.set_observer(
        [this](const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) {
          observe(frame, outcomes);
        });
  }

  std::vector<Estimate> process(const EstimatorEvent& event) override {
    measured_ = {};
    return std::visit(Overloaded{[&](const ImuSample& sample) { return screen(sample); },
                                 [&](const FeatureFrame& frame) { return take(frame); },
                                 // Body velocities are ignored; the IMU measures the motion.
                                 [](const BodyVelocity&) { return std::vector<Estimate>(); }},
                      event);
  }

  EstimatorStatus status() const override {
    EstimatorStatus status{.started = session_.running(),
                           .gyroscope_bias = session_.gyroscope_bias()};
    if (!status.started) {
      status.why_not_started = why_not_initialised(session_.waited(), session_.requirements());
    }
    return status;
  }
  EstimatorReport report() const override {
    EstimatorReport report = report_behind_the_screen();
    report.imu.note(screen_.counts());
    return report;
  }

 protected:
  virtual EstimatorReport report_behind_the_screen() const {
    return {session_.report(), {}, {}, {}};
  }
  virtual std::vector<Estimate> take(const ImuSample& measured) = 0;
  virtual std::vector<Estimate> take(const FeatureFrame& frame) = 0;

  InertialRunSettings settings_;
  InertialSensors sensors_;
  SampleScreen screen_;
  InertialSession session_;

 private:
  std::vector<Estimate> screen(const ImuSample& sample) {
    measured_ = screen_.add(sample);
    std::vector<Estimate> estimates;
    for (const ImuSample& measured : measured_) append(take(measured), estimates);
    return estimates;
  }
};

class InertialFilter : public InertialEstimator {
 public:
  using InertialEstimator::InertialEstimator;

  std::vector<Estimate> finish() override { return session_.finish(); }
  EstimatedMap whole_map() const override {
    Past::Estimates past = session_.past_nav();
    return {.landmarks = std::move(past.landmarks),
            .poses = std::move(past.poses),
            .in_state = session_.in_state()};
  }
  std::optional<LandmarkMap> landmark_map() const override { return session_.landmark_map(); }

 protected:
  std::vector<Estimate> take(const ImuSample& measured) override {
    return session_.process(measured);
  }
  std::vector<Estimate> take(const FeatureFrame& frame) override { return session_.process(frame); }
};

// The filter, followed by batch estimation with the filter's estimates as initial states.
class InertialBatch : public InertialFilter {
 public:
  using InertialFilter::InertialFilter;

  std::vector<Estimate> finish() override { return keep(InertialFilter::finish()); }

  std::vector<Estimate> complete(const StopRequest& stop) override {
    if (material_.estimates.empty() || result_) return {};
    merge_tracks();
    try {
      result_ = smooth_parts(sensors_, settings_, std::move(material_), stop);
    } catch (const BatchStopped&) {
      return {};
    }
    return std::exchange(result_->estimates, {});
  }

  EstimatorStatus status() const override {
    EstimatorStatus status = InertialFilter::status();
    status.smooths = true;
    return status;
  }
  EstimatedMap whole_map() const override {
    return result_ ? EstimatedMap{.landmarks = result_->landmarks} : InertialFilter::whole_map();
  }

 protected:
  EstimatorReport report_behind_the_screen() const override {
    EstimatorReport report = InertialFilter::report_behind_the_screen();
    if (!result_) return report;
    report.batch = result_->report;
    report.batch_terms = result_->terms;
    return report;
  }
  std::vector<Estimate> take(const ImuSample& measured) override {
    material_.samples.push_back(measured);
    return keep(InertialFilter::take(measured));
  }
  std::vector<Estimate> take(const FeatureFrame& frame) override {
    material_.frames.push_back(without_images(frame));
    return keep(InertialFilter::take(frame));
  }

 private:
  // A track that the filter has recognised is a track of that landmark from its beginning.
  void merge_tracks() {
    const std::map<LandmarkId, LandmarkId> known_as = session_.report().known_as;
    if (known_as.empty()) return;
    for (FeatureFrame& frame : material_.frames) {
      for (PixelObservation& o : frame.pixels) {
        const auto known = known_as.find(o.landmark);
        if (known != known_as.end()) o.landmark = known->second;
      }
    }
  }
  std::vector<Estimate> keep(std::vector<Estimate> estimates) {
    material_.estimates.insert(material_.estimates.end(), estimates.begin(), estimates.end());
    const std::optional<InertialStart>& start = session_.start();
    if (start && (material_.starts.empty() || material_.starts.back().time != start->time)) {
      material_.starts.push_back(*start);
    }
    return estimates;
  }

  BatchMaterial material_;
  std::optional<InertialBatchResult> result_;
};

// The session only finds the start; the window begins there, with all events since. Where samples
// are missing for too long the window ends, and another session finds the start of the next one.
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
    append(noted(window_->finish()), estimates);
    return estimates;
  }
  std::vector<Estimate> complete(const StopRequest& /*stop*/) override {
    if (window_ && earlier_.report.landmarks == 0) window_->check();
    return {};
  }

  EstimatorStatus status() const override {
    EstimatorStatus status = InertialEstimator::status();
    if (window_) status.gyroscope_bias = window_->gyroscope_bias();
    return status;
  }
  EstimatedMap whole_map() const override {
    EstimatedMap map{.landmarks = earlier_.map,
                     .in_state = window_ ? window_->in_window() : session_.in_state()};
    const std::vector<MapLandmark> own = window_ ? window_map() : session_.map_nav();
    map.landmarks.insert(map.landmarks.end(), own.begin(), own.end());
    return map;
  }

 protected:
  EstimatorReport report_behind_the_screen() const override {
    EstimatorReport report = InertialEstimator::report_behind_the_screen();
    report.resets += earlier_.resets;
    if (!window_ && earlier_.resets == 0) return report;
    report.window = earlier_.report;
    if (window_) add(window_->report(), *report.window);
    report.imu = report.window->imu;
    report.dropped_frames = report.window->dropped_frames;
    return report;
  }
  std::vector<Estimate> take(const ImuSample& measured) override {
    std::vector<Estimate> estimates;
    if (ends_part(measured)) estimates = end_part();
    if (window_) return noted(window_->process(measured));
    samples_.add(measured);
    const std::vector<Estimate> first = session_.process(measured);
    if (!first.empty()) append(begin(first.front()), estimates);
    return estimates;
  }
  std::vector<Estimate> take(const FeatureFrame& frame) override {
    if (window_) return noted(window_->process(frame));
    frames_.push_back(without_images(frame));
    const std::vector<Estimate> first = session_.process(frame);
    if (!first.empty()) return begin(first.front());
    // A frame may carry a damaged time, so the samples limit what it drops.
    const Time now = samples_.empty() ? frame.time : std::min(frame.time, samples_.newest().time);
    drop_before(now - from_seconds(2 * settings_.start.max_window));
    return {};
  }

 private:
  // The results of the windows before this one.
  struct Earlier {
    std::vector<MapLandmark> map;
    WindowReport report;
    int resets = 0;
  };

  // Of the window.
  std::vector<Estimate> noted(std::vector<Estimate> estimates) {
    for (Estimate& e : estimates) {
      if (place_) add_place(*place_, e);
    }
    if (!estimates.empty()) last_ = estimates.back();
    return estimates;
  }

  // Whether the motion before this sample is unknown.
  bool ends_part(const ImuSample& sample) { return gaps_.add(sample.time) && window_; }

  std::vector<Estimate> end_part() {
    std::vector<Estimate> estimates = noted(window_->finish());
    append_map();
    add(window_->report(), earlier_.report);
    ++earlier_.resets;
    window_.reset();
    session_ = InertialSession(settings_.filter, settings_.start, sensors_);
    return estimates;
  }

  std::vector<MapLandmark> window_map() const {
    std::vector<MapLandmark> map = window_->map();
    for (MapLandmark& l : map) {
      if (place_) add_place(*place_, l);
    }
    return map;
  }

  void append_map() {
    const std::vector<MapLandmark> own = window_map();
    earlier_.map.insert(earlier_.map.end(), own.begin(), own.end());
  }

  // No start uses older data: see InertialSession.
  void drop_before(Time oldest) {
    std::erase_if(frames_, [&](const FeatureFrame& frame) { return frame.time < oldest; });
    samples_.drop_before(oldest);
  }

  // Processes the events until now, in the order of their arrival.
  std::vector<Estimate> begin(const Estimate& first) {
    InertialStart start = start_at(first, session_.start());
    if (last_) start = continued(std::move(start), *last_);
    InertialBatchInput input = batch_input(sensors_, settings_.filter, start);
    if (last_) place_ = take_place(input);
    if (last_ && last_->calibration) {
      begin_at(*last_->calibration, sensors_.cameras, first, input);
      input.calibration = last_->calibration;
    }
    window_.emplace(input, settings_.filter.chart, settings_.batch, settings_.estimator.keyframes);
    std::vector<Estimate> estimates;
    auto sample = samples_.all().begin();
    const auto end = samples_.all().end();
    for (const FeatureFrame& frame : std::exchange(frames_, {})) {
      append(window_->process(frame), estimates);
      for (; sample != end && window_->waiting(); ++sample) {
        append(window_->process(*sample), estimates);
      }
    }
    for (; sample != end; ++sample) append(window_->process(*sample), estimates);
    samples_.clear();
    return noted(std::move(estimates));
  }

  WaitingSamples samples_;
  std::deque<FeatureFrame> frames_;
  std::optional<InertialWindow> window_;
  Earlier earlier_;
  TimeGaps gaps_;
  std::optional<Place> place_;  // of the window, after a gap
  std::optional<Estimate> last_;
};

}  // namespace

std::unique_ptr<Estimator> make_estimator(const InertialRunSettings& settings,
                                          InertialSensors sensors,
                                          std::optional<InertialStart> start,
                                          std::shared_ptr<const LandmarkMap> prior) {
  validate(settings);
  if (prior &&
      (!settings.estimator.is_filter() || settings.filter.recognise != Recognise::kAppearance)) {
    throw UsageError("a map is for a filter with recognise=appearance");
  }
  if (settings.start.in_map && !prior) {
    throw UsageError(
        "start.in_map: true, but there is no map: expected a map of an earlier run (--map)");
  }
  if (settings.start.in_map && start) {
    throw UsageError(
        "start.in_map: true, but the start is given: expected one of them, the start in the map or "
        "the given one (--begin)");
  }
  sensors.pixel_sigma = settings.filter.pixel_sigma.value_or(sensors.pixel_sigma);
  if (const auto& readout = settings.filter.readout_time) set_readout(*readout, sensors.cameras);
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
  return std::make_unique<InertialFilter>(settings, std::move(sensors), std::move(start),
                                          std::move(prior));
}

}  // namespace chasles
