#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <chasles/calibrate/cameras_calibration.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/report/calibration_page.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/target/target_detector.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// Which views of a target a calibration takes.
struct ViewsOptions {
  std::vector<std::filesystem::path> recordings;
  std::filesystem::path target;
  std::string lens = "auto";  ///< one model, several with commas, or "auto"
  int every = 1, threads = 1;
  bool from_nothing = false, quiet = false, live = false;
  bool follows_target = false;  ///< the target's pose must go on from view to view
  /// Images that were searched before (ViewOptions::known).
  std::function<const TargetDetection*(const std::filesystem::path& file)> known = {};
};

/// Adds the arguments and options. `has_imu`: of recordings with an IMU, with a target or without.
void declare_views(CLI::App& parser, ViewsOptions& o, bool has_imu);

/// The views of a recording, with its cameras; those of a further recording come later in time.
void gather_views(const ViewsOptions& o, const Recording& recording, const Interrupt& interrupt,
                  CamerasInput& input, std::vector<std::string>& remarks);

/// Throws InputError for a board that looks the same after half a turn, where that matters.
void check_symmetry(const ViewsOptions& o, const Target& target, std::size_t cameras);

/// The lenses of the option. Throws UsageError.
std::vector<LensForm> candidate_lenses(const ViewsOptions& o);

/// Throws UsageError where a recording is there twice.
void check_different(const std::vector<std::filesystem::path>& recordings);

/// For results: a calibration.yaml in a recording would calibrate its next run, and files of an
/// earlier calibration would stay beside those of this one. Throws UsageError for a folder that is
/// not empty.
void check_is_new(const std::filesystem::path& folder);

/// What the page of a calibration draws of its views.
std::vector<CalibrationView> page_views(const std::vector<ExplainedView>& views);

/// An empty input for a target, whose shape is estimated.
CamerasInput input_for(const Target& target);

}  // namespace chasles::app
