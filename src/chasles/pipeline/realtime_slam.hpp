#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include <chasles/pipeline/visual_inertial_slam.hpp>

namespace chasles {

/// VisualInertialSlam on a thread of its own, for a program whose callbacks must not wait. The
/// estimates are the same bytes as without the thread, unless images are dropped. Any thread may
/// call.
class RealtimeSlam {
 public:
  struct Options {
    /// Images that may wait for the estimator. One more, and the oldest of them is dropped, so that
    /// the delay stays bounded. 0: all wait.
    std::size_t most_images = 3;
    /// Then process() of images waits for room instead, and nothing is dropped: for recordings,
    /// which come faster than the estimator takes them.
    bool waits_for_room = false;
    /// Held while the estimator works, in a program with batch estimation elsewhere, which is not
    /// reentrant (docs/architecture.md); must outlive this. Null: none.
    std::timed_mutex* turn = nullptr;
  };
  /// Images, except `waiting`, which is a number at this instant.
  struct Counts {
    std::size_t came = 0, taken = 0, dropped = 0, waiting = 0;
  };
  /// Called on the estimator's thread with the estimates of one sample or image, and the estimator
  /// for its map, report and so on. Must not call ask() or finish().
  using Callback = std::function<void(std::span<const Estimate>, VisualInertialSlam&)>;

  RealtimeSlam(std::unique_ptr<VisualInertialSlam> slam, Options options,
               Callback on_estimates = {});
  RealtimeSlam(const RealtimeSlam&) = delete;
  RealtimeSlam& operator=(const RealtimeSlam&) = delete;
  /// What still waits is lost; see finish().
  ~RealtimeSlam();

  /// Returns at once. An error of the estimator or of the callback ends the work; it is rethrown by
  /// the next call of process(), ask() or finish().
  void process(const ImuSample& sample);
  /// The same in two steps, for a program that puts its sensors in order: predicted() uses the
  /// sample as soon as it has come, and the estimator gets it when its turn comes.
  void predict_with(const ImuSample& sample);
  void pass_on(const ImuSample& sample);
  /// The same, unless it waits for room. A number of images other than that of the cameras, or an
  /// image of another size than its camera's, throws InputError; the images are then ignored.
  /// Returns the number of images that this one displaced.
  std::size_t process(ImageFrame images);

  /// The state at a time since the last estimate, by the samples that have come so far
  /// (StatePredictor); none where there is none. Never waits for the estimator.
  std::optional<PredictedState> predicted(Time time) const;

  /// Calls the function on the estimator's thread, between two events, and waits for it.
  void ask(const std::function<void(VisualInertialSlam&)>& question);
  /// The same also after an error, on what the estimator had until then.
  void ask_in_any_case(const std::function<void(VisualInertialSlam&)>& question) {
    ask_while(question, {});
  }
  /// The error that has ended the work; null: none.
  std::exception_ptr failure() const;

  /// Waits until all that has come is processed; then as VisualInertialSlam::finish(), whose
  /// estimates the callback does not get. Where `stop` returns true it ends without estimates, and
  /// may be called again, unless batch estimation had begun; otherwise neither it nor process() may
  /// be called after it. `stop` is called on the thread of the caller.
  std::vector<Estimate> finish(const StopRequest& stop = {});

  Counts counts() const;
  /// Of what has reached the estimator so far.
  ArrivalCounts arrivals() const;

 private:
  void ask_while(const std::function<void(VisualInertialSlam&)>& question,
                 const std::function<void()>& waiting);
  void work();
  void take(SensorEvent event);
  std::unique_lock<std::timed_mutex> take_turn();
  std::size_t drop_oldest_image();
  void note(std::span<const Estimate> estimates);
  void rethrow_failure();

  const std::unique_ptr<VisualInertialSlam> slam_;
  const std::vector<Camera> cameras_;
  const Options options_;
  const Callback on_estimates_;

  /// At the time of arrival, for controllers. That of slam_ is at the time of the estimator: who
  /// gets an estimate gets the state of its time, however far the samples are ahead.
  mutable std::mutex predictor_mutex_;
  mutable StatePredictor predictor_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<SensorEvent> events_;
  std::deque<std::function<void()>> questions_;
  Counts counts_;
  ArrivalCounts arrivals_;
  bool busy_ = false, stop_ = false, finished_ = false;
  std::exception_ptr failure_;
  std::thread worker_;  // last, because it uses all members above
};

}  // namespace chasles
