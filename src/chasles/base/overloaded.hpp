#pragma once

namespace chasles {

/// A visitor for std::visit with one lambda per type. A type without a lambda does not compile.
template <typename... Lambdas>
struct Overloaded : Lambdas... {
  using Lambdas::operator()...;
};
template <typename... Lambdas>
Overloaded(Lambdas...) -> Overloaded<Lambdas...>;

}  // namespace chasles
