#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/check/check.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/masks.hpp>
#include <chasles/recording/readers.hpp>

#include "diagnosis.hpp"
#include "inertial_settings_io.hpp"
#include "print.hpp"
#include "remarks.hpp"
#include "run_input.hpp"
#include "subcommands.hpp"
#include "truth_preparation.hpp"

namespace chasles::app {
namespace {

struct CheckOptions {
  std::filesystem::path recording;
  std::filesystem::path truth = {};
  TruthOptions truth_options = {};
  double seconds = kCheckedSeconds;
  SettingSources settings = {};
  bool json = false;
};

constexpr std::size_t kLine = 100;

// Three significant digits; 0 for a negligible number.
std::string number(double value) {
  if (std::abs(value) < 1e-3) return "0";
  return std::abs(value) >= 1000 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() ? number(value) : fmt::format("{} {}", number(value), unit);
}

// The distinct subjects of the facts, in their order.
std::vector<std::string> subjects(const CheckReport& report) {
  std::vector<std::string> names;
  for (const Fact& fact : report.facts) {
    if (std::find(names.begin(), names.end(), fact.about) == names.end()) {
      names.push_back(fact.about);
    }
  }
  return names;
}

// The facts of one subject, broken into lines.
std::string facts_text(const CheckReport& report, const std::string& about) {
  std::string text, line = fmt::format("  {:<11}", about);
  const std::size_t indent = line.size();
  for (const Fact& fact : report.facts) {
    if (fact.about != about) continue;
    const std::string part = fmt::format("{} {}", fact.name, with_unit(fact.value, fact.unit));
    if (line.size() > indent && line.size() + part.size() + 2 > kLine) {
      text += line + ",\n";
      line.assign(indent, ' ');
    }
    line += (line.size() > indent ? ", " : "") + part;
  }
  return text + line + "\n";
}

std::string finding_text(const Finding& finding) {
  const std::string limit =
      finding.threshold == 0
          ? std::string()
          : fmt::format("limit {}; ", with_unit(finding.threshold, finding.unit));
  return fmt::format("  {:<9}{}: {}\n           {}{}\n", severity_name(finding.severity),
                     finding.about, finding.what, limit, finding.advice);
}

std::string heading(const CheckReport& report) {
  const std::size_t count = report.findings.size();
  if (count == 0) return "\nNo findings.\n";
  return fmt::format("\n{} finding{}:\n", count, count == 1 ? "" : "s");
}

}  // namespace

std::string check_text(const Recording& recording, const CheckReport& report) {
  std::string text = recording.name + "\n";
  for (const std::string& about : subjects(report)) text += facts_text(report, about);
  text += heading(report);
  for (const Finding& finding : report.findings) text += finding_text(finding);
  if (!report.not_checked.empty()) text += "\nNot checked:\n";
  for (const std::string& sentence : report.not_checked) text += "  " + sentence + "\n";
  if (!recording.remarks.empty()) text += "\nRemarks of the reader:\n";
  for (const std::string& sentence : recording.remarks) text += "  " + sentence + "\n";
  return text;
}

nlohmann::ordered_json check_json(const Recording& recording, const CheckReport& report) {
  nlohmann::ordered_json json{{"name", recording.name},
                              {"facts", nlohmann::ordered_json::object()},
                              {"findings", nlohmann::ordered_json::array()},
                              {"not_checked", report.not_checked},
                              {"remarks", recording.remarks}};
  for (const Fact& fact : report.facts) {
    json["facts"][fact.about][fact.name] = {{"value", fact.value}, {"unit", fact.unit}};
  }
  for (const Finding& finding : report.findings) {
    json["findings"].push_back({{"severity", severity_name(finding.severity)},
                                {"about", finding.about},
                                {"what", finding.what},
                                {"value", finding.value},
                                {"threshold", finding.threshold},
                                {"unit", finding.unit},
                                {"advice", finding.advice}});
  }
  return json;
}

namespace {

Recording read_checked(const CheckOptions& o) {
  Recording recording = read_recording(o.recording);
  const RemarksOnError remarks(recording);
  recording.pairing = pairing_from(o.truth_options);
  if (!o.truth.empty()) {
    replace_truth(recording, o.truth, o.truth_options);
  } else if (!recording.truth.empty()) {
    mend_own_truth(recording, o.truth_options);
  }
  if (!recording.truth.empty() && is_offset_auto(o.truth_options)) {
    if (recording.imu.empty()) {
      throw UsageError(
          "--truth-time-offset auto: the recording has no gyroscope, expected seconds");
    }
    const PreparedTruth prepared_truth = prepare_truth(gyroscope_reference(recording),
                                                       {.attitudes = recording.truth_attitudes,
                                                        .point_imu = recording.truth_point_imu,
                                                        .estimate_offset = true,
                                                        .pairing = recording.pairing},
                                                       recording.truth);
    for (const std::string& remark : prepared_truth.remarks) recording.remarks.push_back(remark);
  }
  return recording;
}

int run(const CheckOptions& o) {
  const FrontendSettings frontend = inertial_run_settings_from(o.settings).frontend;
  Recording recording = read_checked(o);
  std::ranges::move(mask_remarks(frontend.mask, recording.cameras),
                    std::back_inserter(recording.remarks));
  const RemarksOnError remarks(recording);
  const CheckReport report = diagnose(recording, o.seconds, frontend);
  app::print("{}", o.json ? json_text(check_json(recording, report), 2) + "\n"
                          : check_text(recording, report));
  return static_cast<int>(has_error(report) ? ExitCode::kBadInput : ExitCode::kOk);
}

}  // namespace

Action declare_check(CLI::App& parser) {
  const auto o = std::make_shared<CheckOptions>();
  parser.add_option("RECORDING", o->recording, "Recording to check")->required()->type_name("");
  parser
      .add_option("--seconds", o->seconds,
                  "Of images: length of the part that is tracked, the one with the most rotation")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1e5))
      ->type_name("S");
  parser
      .add_option("--truth", o->truth,
                  "True trajectory, as for run (default: the recording's own): it is examined with "
                  "the gyroscope")
      ->type_name("FILE");
  declare_truth(parser, o->truth_options, "Truth");
  parser
      .add_option("--set", o->settings.sets,
                  "A setting of the front end as for `run`: KEY=VALUE, such as frontend.mask=FILE; "
                  "may be repeated")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  parser.add_option("--config", o->settings.config, "Settings from a YAML file, as for `run`")
      ->type_name("FILE");
  parser.add_flag("--json", o->json, "Print facts and findings as JSON");
  parser.footer(frontend_settings_help());
  return [o] { return run(*o); };
}

}  // namespace chasles::app
