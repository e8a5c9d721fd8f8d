#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/base/overloaded.hpp>
#include <chasles/frontend/frontend_checks.hpp>
#include <chasles/pipeline/realtime_slam.hpp>

namespace chasles {
namespace {

constexpr std::chrono::milliseconds kBetweenRequests(50);

}  // namespace

RealtimeSlam::RealtimeSlam(std::unique_ptr<VisualInertialSlam> slam, Options options,
                           Callback on_estimates)
    : slam_(std::move(slam)),
      cameras_(slam_->cameras()),
      options_(options),
      on_estimates_(std::move(on_estimates)),
      predictor_(slam_->predictor().with(StatePredictor::Work::kAtOnce)) {
  worker_ = std::thread([this] { work(); });
}

RealtimeSlam::~RealtimeSlam() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    changed_.notify_all();
  }
  worker_.join();
}

void RealtimeSlam::process(const ImuSample& sample) {
  predict_with(sample);
  pass_on(sample);
}

void RealtimeSlam::predict_with(const ImuSample& sample) {
  const std::lock_guard lock(predictor_mutex_);
  predictor_.add(sample);
}

void RealtimeSlam::pass_on(const ImuSample& sample) {
  const std::lock_guard lock(mutex_);
  rethrow_failure();
  if (finished_) throw UsageError("RealtimeSlam: expected no sample after finish()");
  events_.emplace_back(sample);
  changed_.notify_all();
}

std::size_t RealtimeSlam::process(ImageFrame images) {
  check_frame(images, {}, std::nullopt, cameras_);
  std::unique_lock lock(mutex_);
  if (options_.waits_for_room) {
    changed_.wait(lock, [&] { return failure_ || counts_.waiting < options_.most_images; });
  }
  rethrow_failure();
  if (finished_) throw UsageError("RealtimeSlam: expected no images after finish()");
  ++counts_.came;
  ++counts_.waiting;
  events_.emplace_back(std::move(images));
  const bool full = options_.most_images > 0 && counts_.waiting > options_.most_images;
  changed_.notify_all();
  return full ? drop_oldest_image() : 0;
}

std::size_t RealtimeSlam::drop_oldest_image() {
  const auto oldest = std::ranges::find_if(
      events_, [](const SensorEvent& event) { return std::holds_alternative<ImageFrame>(event); });
  events_.erase(oldest);
  --counts_.waiting;
  ++counts_.dropped;
  return 1;
}

std::optional<PredictedState> RealtimeSlam::predicted(Time time) const {
  const std::lock_guard lock(predictor_mutex_);
  return predictor_.at(time);
}

RealtimeSlam::Counts RealtimeSlam::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

ArrivalCounts RealtimeSlam::arrivals() const {
  const std::lock_guard lock(mutex_);
  return arrivals_;
}

std::exception_ptr RealtimeSlam::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void RealtimeSlam::ask(const std::function<void(VisualInertialSlam&)>& question) {
  if (const std::exception_ptr failure = this->failure()) std::rethrow_exception(failure);
  ask_in_any_case(question);
}

// Calls `waiting` until there is an answer.
void RealtimeSlam::ask_while(const std::function<void(VisualInertialSlam&)>& question,
                             const std::function<void()>& waiting) {
  std::packaged_task<void()> task([&] {
    const auto turn = take_turn();
    question(*slam_);
  });
  std::future<void> answered = task.get_future();
  {
    const std::lock_guard lock(mutex_);
    questions_.emplace_back([&] { task(); });
    changed_.notify_all();
  }
  while (waiting && answered.wait_for(kBetweenRequests) != std::future_status::ready) waiting();
  answered.get();
}

std::vector<Estimate> RealtimeSlam::finish(const StopRequest& stop) {
  {
    std::unique_lock lock(mutex_);
    finished_ = true;
    const auto is_done = [&] { return failure_ || (events_.empty() && !busy_); };
    while (!changed_.wait_for(lock, kBetweenRequests, is_done)) {
      lock.unlock();  // `stop` may wait for another thread that calls
      if (stop && stop()) return {};
      lock.lock();
    }
  }
  std::vector<Estimate> estimates;
  ArrivalCounts arrivals;
  std::atomic<bool> stopped = false;
  if (const std::exception_ptr failure = this->failure()) std::rethrow_exception(failure);
  ask_while(
      [&](VisualInertialSlam& slam) {
        estimates = slam.finish([&] { return stopped.load(); });
        arrivals = slam.arrivals();
      },
      [&] { stopped = stopped || (stop && stop()); });
  {
    const std::lock_guard lock(mutex_);
    arrivals_ = arrivals;
  }
  if (stopped) return {};
  if (!estimates.empty()) {
    const std::lock_guard lock(predictor_mutex_);
    predictor_.correct(estimates.back());
  }
  return estimates;
}

// The estimator's thread. Questions come first: they are few, and somebody waits for them.
void RealtimeSlam::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    busy_ = false;
    changed_.notify_all();
    changed_.wait(lock,
                  [&] { return stop_ || !questions_.empty() || (!events_.empty() && !failure_); });
    if (!questions_.empty()) {
      const std::function<void()> question = std::move(questions_.front());
      questions_.pop_front();
      lock.unlock();
      question();
      lock.lock();
      continue;
    }
    if (stop_) return;
    busy_ = true;
    SensorEvent event = std::move(events_.front());
    events_.pop_front();
    if (std::holds_alternative<ImageFrame>(event)) {
      --counts_.waiting;
      ++counts_.taken;
    }
    lock.unlock();
    std::exception_ptr failure;
    try {
      take(std::move(event));
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    arrivals_ = slam_->arrivals();
    if (failure) failure_ = failure;
  }
}

void RealtimeSlam::take(SensorEvent event) {
  std::vector<Estimate> estimates;
  {
    const auto turn = take_turn();
    estimates =
        std::visit(Overloaded{[&](const ImuSample& sample) { return slam_->process(sample); },
                              [&](ImageFrame& images) { return slam_->process(std::move(images)); },
                              [](const auto& /*other*/) { return std::vector<Estimate>(); }},
                   event);
  }
  note(estimates);
}

std::unique_lock<std::timed_mutex> RealtimeSlam::take_turn() {
  return options_.turn ? std::unique_lock(*options_.turn) : std::unique_lock<std::timed_mutex>();
}

void RealtimeSlam::note(std::span<const Estimate> estimates) {
  if (estimates.empty()) return;
  {
    const std::lock_guard lock(predictor_mutex_);
    predictor_.correct(estimates.back());
  }
  if (on_estimates_) on_estimates_(estimates, *slam_);
}

void RealtimeSlam::rethrow_failure() {
  if (failure_) std::rethrow_exception(failure_);
}

}  // namespace chasles
