#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include <pybind11/pybind11.h>

#include <chasles/base/interruption.hpp>

#include "turns.hpp"

namespace chasles::python {

/// A call that may take long: it works on a thread of its own, while this one lets Python handle
/// its signals, such as Ctrl-C, and draws the progress bar. Python handles signals in its main
/// thread; called from another one, the call cannot be interrupted.
class LongCall {
 public:
  /// `progress`: None, or called as progress(done, total), with total 0 where it is not known.
  /// `bars`: whether the bars of the command are drawn.
  enum class Bars { kOfCommand, kNone };
  explicit LongCall(pybind11::object progress = pybind11::none(), Bars bars = Bars::kNone)
      : progress_(std::move(progress)) {
    state_.quiet = bars == Bars::kNone;
  }
  LongCall(const LongCall&) = delete;
  LongCall& operator=(const LongCall&) = delete;

  /// Does the work, without the GIL, and returns its result. Throws what it throws, and what a
  /// handler of a signal or `progress` raises; the work is then asked to end by an
  /// interruption_point(), and by stopped(). With the GIL.
  template <typename Work>
  auto operator()(const Work& work) {
    if constexpr (std::is_void_v<decltype(work())>) {
      watch(work);
    } else {
      std::optional<decltype(work())> result;
      watch([&] { result.emplace(work()); });
      return std::move(*result);
    }
  }

  /// The same in a turn (take_turn()).
  template <typename Work>
  auto in_turn(const Work& work) {
    reject_in_call();
    return (*this)([&] {
      const auto turn = take_turn();
      return work();
    });
  }

  /// Whether the work is asked to end. Any thread.
  bool stopped() const { return state_.stop; }
  /// For the progress bar. Any thread.
  void show(std::size_t done, std::size_t total) {
    state_.done = done;
    state_.total = total;
  }

 private:
  void watch(const std::function<void()>& work);
  void poll();

  pybind11::object progress_;
  CallProgress state_;
  std::unique_ptr<pybind11::error_already_set> raised_;
};

}  // namespace chasles::python
