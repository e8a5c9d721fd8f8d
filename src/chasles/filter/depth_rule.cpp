#include <cmath>
#include <sstream>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/base/registered_names.hpp>
#include <chasles/filter/depth_rule.hpp>

namespace chasles {
namespace {

constexpr std::string_view kConstantRule = "constant";

RegisteredNames<DepthRule>& registered_rules() {
  static auto* const all = new RegisteredNames<DepthRule>("depth rule", {kConstantRule});
  return *all;
}

bool is_positive(double number) { return std::isfinite(number) && number > 0; }

// The rule, with its results checked.
DepthRule checked(std::string name, DepthRule rule) {
  return [name = std::move(name), rule = std::move(rule)](const FirstObservation& observation) {
    const std::optional<AssumedDepth> depth = rule(observation);
    if (depth && (!is_positive(depth->mean) || !is_positive(depth->sigma))) {
      std::ostringstream text;
      text << "depth rule '" << name << "': found " << depth->mean << " +- " << depth->sigma
           << ", expected two positive numbers ["
           << (observation.inverse ? "1/m] of the inverse depth" : "m] of the depth")
           << ", or none for no landmark";
      throw UsageError(text.str());
    }
    return depth;
  };
}

}  // namespace

void register_depth_rule(std::string name, DepthRule rule) {
  registered_rules().check(name);
  if (!rule) throw UsageError("depth rule '" + name + "': expected a function");
  DepthRule whole = checked(name, std::move(rule));
  registered_rules().add(std::move(name), std::move(whole));
}

std::span<const std::string_view> depth_rule_names() { return registered_rules().names(); }

DepthRule depth_rule(std::string_view name) {
  if (name == kConstantRule) return {};
  if (const DepthRule* rule = registered_rules().find(name)) return *rule;
  registered_rules().throw_unknown(name);
}

}  // namespace chasles
