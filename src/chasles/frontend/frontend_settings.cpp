#include <cmath>
#include <sstream>

#include <chasles/error.hpp>
#include <chasles/frontend/frontend_settings.hpp>

namespace chasles {
namespace {

void require(const char* name, double value, double low, double high) {
  if (std::isfinite(value) && value >= low && value <= high) return;
  std::ostringstream message;
  message << "setting " << name << ": found " << value << ", expected " << low << " to " << high;
  throw UsageError(message.str());
}

void require_choice(const char* name, const std::string& value, const std::string& choices) {
  if (!value.empty() && value.find('|') == std::string::npos &&
      ("|" + choices + "|").find("|" + value + "|") != std::string::npos) {
    return;
  }
  throw UsageError(std::string("setting ") + name + ": found \"" + value + "\", expected one of " +
                   choices);
}

}  // namespace

void check(const FrontendSettings& s) {
  require_choice("corners", s.corners, "harris|shi-tomasi");
  require_choice("equalisation", s.equalisation, "none|histogram|clahe");
  require("max_tracks", s.max_tracks, 1, 10000);
  require("grid_columns", s.grid_columns, 1, 100);
  require("grid_rows", s.grid_rows, 1, 100);
  require("cells_per_frame", s.cells_per_frame, 1, 10000);
  require("min_distance", s.min_distance, 1, 1000);
  require("border", s.border, 0, 1000);
  require("min_corner_gradient", s.min_corner_gradient, 0, 255);
  require("window", s.window, 7, 23);
  if (s.window % 2 == 0) {
    throw UsageError("setting window: found " + std::to_string(s.window) +
                     ", expected an odd number: a patch has a middle");
  }
  require("levels", s.levels, 1, 6);
  require("predicted_levels", s.predicted_levels, 1, s.levels);
  require("min_correlation", s.min_correlation, -1, 1);
  require("max_backward_error", s.max_backward_error, 0.01, 1000);
  require("waiting_frames", s.waiting_frames, 0, 10000);
  require("patch_frames", s.patch_frames, 1, 100);
  require("min_kept_correlation", s.min_kept_correlation, -1, 1);
  require("max_stretch", s.max_stretch, 1, 1000);
  require("outlier_threshold", s.outlier_threshold, 0.01, 1000);
  require("epipolar_threshold", s.epipolar_threshold, 0.01, 1000);
  require("min_stereo_depth", s.min_stereo_depth, 0.01, 1000);
}

}  // namespace chasles
