#include "method_options.hpp"

#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace chasles::app {
namespace {

std::string chart_help() {
  std::string text = "Error chart:";
  for (const ErrorChart& chart : error_charts()) text += fmt::format(" {}", chart.name);
  return text;
}

}  // namespace

void declare_method(CLI::App& parser, SessionOptions& o, const std::string& estimator) {
  const auto add = [&](const char* name, auto& value, const char* type, const std::string& text) {
    return parser.add_option(name, value, text)->type_name(type)->group("Method");
  };
  add("--mode", o.settings.mode, "NAME",
      "localize: trajectory from velocities only; map: landmarks along a given trajectory; slam: "
      "both (default)");
  add("--chart", o.settings.chart, "NAME", chart_help());
  add("--config", o.settings.config, "FILE", "Settings from a YAML file, `key: value` a line");
  add("--begin", o.begin, "auto|truth",
      "start of a visual-inertial run; auto: static or dynamic initialisation (default); truth: "
      "the true state");
  parser
      .add_flag(
          "--as-recorded", o.as_recorded,
          "Take clock, axes and shutter as the recording states them, without what its images "
          "and the gyroscope show of them (docs/cameras.md)")
      ->group("Method");
  add("--estimator", o.estimator, "filter|batch|window:N",
      "filter; batch: the most probable motion given the whole recording, starting from the "
      "filter's estimate (docs/batch.md); window:N: at every frame the most probable motion of the "
      "last N frames, given the recording so far (docs/window.md) (default: " +
          estimator + ")");
  add("--set", o.settings.sets, "KEY=VALUE", "One setting; may be repeated, the last one counts")
      ->allow_extra_args(false);
}

std::string method_help() {
  VelocitySlamSettings defaults;
  ReaderSettings reader;
  return "Settings, for --set and --config (auto: measured from the recording):\n" +
         help_text(setting_list(defaults)) + help_text(setting_list(reader)) + "\n" +
         filter_settings_help() + "\n" + inertial_run_settings_help();
}

}  // namespace chasles::app
