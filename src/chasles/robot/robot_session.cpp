#include <utility>

#include <chasles/base/overloaded.hpp>
#include <chasles/robot/robot_session.hpp>
#include <chasles/session/output_folder.hpp>

namespace chasles {
namespace {

using Clock = std::chrono::steady_clock;

// Frames that wait before feed() does, with `lossless`.
constexpr std::size_t kMostLossless = 16;
// Between two checks of what the estimator says of itself.
constexpr auto kBetweenPolls = std::chrono::milliseconds(500);

}  // namespace

RobotSession::RobotSession(std::unique_ptr<VisualInertialSlam> made, const RobotSetup& setup,
                           const Recording& sensors, const InertialRunSettings& of_run,
                           const RealtimeSlam::Callback& on_estimates)
    : order_({.cameras = setup.calibration.cameras.size(),
              .patience = setup.lossless ? Time::max() : SensorOrder::Options{}.patience}),
      leaps_of_images_(setup.calibration.cameras.size()),
      callback_(on_estimates) {
  if (!setup.output.empty()) log_.emplace(sensors, setup.settings, of_run, made->estimator());
  made->set_frame_observer([this, &estimator = made->estimator()](const FeatureFrame& frame) {
    if (log_) log_->add(frame);
    if (Clock::now() - last_inspection_ >= kBetweenPolls) inspect(estimator);
  });
  inspect(made->estimator());
  slam_.emplace(
      std::move(made),
      RealtimeSlam::Options{.most_images = setup.lossless
                                               ? kMostLossless
                                               : static_cast<std::size_t>(setup.most_images),
                            .waits_for_room = setup.lossless},
      [this](std::span<const Estimate> estimates, VisualInertialSlam& of) { note(estimates, of); });
}

// On the estimator's thread. What it says of itself, for whoever must not wait for it.
void RobotSession::inspect(const Estimator& estimator) {
  last_inspection_ = Clock::now();
  const std::string why = estimator.started() ? "" : estimator.why_not_started();
  const int resets = estimator.report().resets;
  const std::lock_guard lock(state_mutex_);
  why_not_started_ = why;
  recoveries_ = resets;
}

// On the estimator's thread.
void RobotSession::note(std::span<const Estimate> estimates, VisualInertialSlam& of) {
  if (estimates.empty()) return;
  if (!has_estimate_) inspect(of.estimator());
  for (const Estimate& e : estimates) latency_.estimated(e.time);
  {
    const std::lock_guard lock(state_mutex_);
    last_ = estimates.back();
  }
  has_estimate_ = true;
  if (log_) log_->add(estimates);
  const std::lock_guard lock(callback_mutex_);
  if (!ended_ && callback_) callback_(estimates, of);
}

void RobotSession::end_callbacks() {
  const std::lock_guard lock(callback_mutex_);
  ended_ = true;
}

std::vector<ImuSample> RobotSession::feed(const ImuSample& sample) {
  return feed(sample, leaps_of_samples_);
}

std::vector<ArrivedImage> RobotSession::feed(ArrivedImage image) {
  auto& leaps = leaps_of_images_[image.camera];
  return feed(std::move(image), leaps);
}

template <typename Message>
std::vector<Message> RobotSession::feed(Message message, StampLeaps<Message>& leaps) {
  const std::lock_guard lock(order_mutex_);
  if (finished_) return {};
  auto passed = leaps.add(std::move(message));
  if (passed.jumped_back) return std::move(passed.messages);
  for (Message& one : passed.messages) take(std::move(one));
  pass_on(order_.take());
  return {};
}

void RobotSession::finish() {
  const std::lock_guard lock(order_mutex_);
  if (finished_) return;
  finished_ = true;
  failure_ = error_of([&] {
    if (auto sample = leaps_of_samples_.finish()) take(*sample);
    for (auto& leaps : leaps_of_images_) {
      if (auto image = leaps.finish()) take(std::move(*image));
    }
    pass_on(order_.finish());
    const std::vector<Estimate> rest = slam_->finish();
    slam_->ask([&](VisualInertialSlam& of) {
      note(rest, of);
      inspect(of.estimator());
    });
  });
}

// `order_mutex_` is locked in the next three.
void RobotSession::take(const ImuSample& sample) {
  slam_->predict_with(sample);
  {
    const std::lock_guard lock(state_mutex_);
    ++samples_;
  }
  order_.add(sample);
}

void RobotSession::take(ArrivedImage&& image) {
  if (image.camera == 0) latency_.arrived(image.time, image.arrived);
  order_.add(image.camera, image.time, std::move(image.image));
}

void RobotSession::pass_on(std::vector<SensorEvent> events) {
  {
    const std::lock_guard lock(state_mutex_);
    counts_ = order_.counts();
    wrong_stamps_ = leaps_of_samples_.wrong();
    for (const auto& leaps : leaps_of_images_) wrong_stamps_ += leaps.wrong();
  }
  for (SensorEvent& event : events) {
    std::visit(Overloaded{[&](const ImuSample& sample) { slam_->pass_on(sample); },
                          [&](ImageFrame& images) { slam_->process(std::move(images)); },
                          [](const auto& /*other*/) {}},
               event);
  }
}

RobotReport RobotSession::report() {
  RobotReport report;
  report.images = slam_->counts();
  if (const auto latency = latency_.take()) {
    report.mean_latency = latency->mean;
    report.worst_latency = latency->worst;
  }
  {
    const std::lock_guard lock(state_mutex_);
    report.last = last_;
    report.samples = samples_;
    report.order = counts_;
    report.wrong_stamps = wrong_stamps_;
    report.why_not_started = why_not_started_;
    report.recoveries = recoveries_;
  }
  if (const auto error = slam_->failure()) {  // the next message begins the run anew
    report.why_not_started = "the estimator ended: " + text_of(error);
  }
  return report;
}

void RobotSession::write_run_folder(const std::filesystem::path& folder) {
  prepare_output(folder);
  slam_->ask_in_any_case([&](const VisualInertialSlam& /*slam*/) { log_->write(folder); });
}

}  // namespace chasles
