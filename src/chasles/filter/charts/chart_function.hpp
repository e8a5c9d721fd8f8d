#pragma once

#include <cstddef>
#include <functional>
#include <utility>

namespace chasles {

/// A function of an error chart: a plain one, or one that a program made at run time and owns
/// (register_error_chart). Constant-initialised where it is plain, so that charts are ready before
/// any other object.
template <typename Signature>
class ChartFunction;

template <typename Result, typename... Arguments>
class ChartFunction<Result(Arguments...)> {
 public:
  constexpr ChartFunction(Result (*plain)(Arguments...)) : plain_(plain) {}
  constexpr ChartFunction(std::nullptr_t) {}
  /// `made` must live as long as this; an empty one makes an empty function.
  explicit ChartFunction(const std::function<Result(Arguments...)>& made)
      : made_(made ? &made : nullptr) {}

  Result operator()(Arguments... arguments) const {
    return plain_ ? plain_(std::forward<Arguments>(arguments)...)
                  : (*made_)(std::forward<Arguments>(arguments)...);
  }
  constexpr explicit operator bool() const { return plain_ || made_; }

 private:
  Result (*plain_)(Arguments...) = nullptr;
  const std::function<Result(Arguments...)>* made_ = nullptr;
};

template <typename Result, typename... Arguments>
ChartFunction(const std::function<Result(Arguments...)>&) -> ChartFunction<Result(Arguments...)>;

}  // namespace chasles
