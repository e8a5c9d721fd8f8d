#pragma once

namespace chasles {

/// A visitor of several lambdas, for std::visit: one a type. A type without its lambda does not
/// compile.
template <typename... Lambdas>
struct Overloaded : Lambdas... {
  using Lambdas::operator()...;
};
template <typename... Lambdas>
Overloaded(Lambdas...) -> Overloaded<Lambdas...>;

}  // namespace chasles
