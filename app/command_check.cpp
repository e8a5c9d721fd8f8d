#include <algorithm>
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
#include <chasles/session/check_motion_calibration.hpp>
#include <chasles/session/diagnosis.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/recording_input.hpp>
#include <chasles/session/remarks.hpp>
#include <chasles/session/truth_preparation.hpp>

#include "declare_truth.hpp"
#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

struct CheckOptions {
  std::filesystem::path recording;
  std::filesystem::path truth = {};
  TruthOptions truth_options = {};
  double seconds = kCheckedSeconds;
  SettingSources settings = {};
  bool motion = false;  // compares the calibration with it
  bool json = false;
};

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
  CheckReport report = diagnose(recording, o.seconds, frontend);
  if (o.motion) {
    const Interrupt interrupt;
    SessionOptions options;
    options.input.recording = o.recording;
    options.settings = o.settings;
    compare_with_motion(
        options, recording, [&] { return interrupt.requested(); }, report);
  }
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
  parser.add_flag("--calibration", o->motion,
                  "Compare lenses, mounting and clock with what batch estimation of the whole "
                  "recording finds, in sigmas; needs about as long as the recording");
  parser.add_flag("--json", o->json, "Print facts and findings as JSON");
  parser.footer(frontend_settings_help());
  return [o] { return run(*o); };
}

}  // namespace chasles::app
