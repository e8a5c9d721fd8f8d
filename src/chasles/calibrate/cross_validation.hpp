#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <chasles/calibrate/cameras_calibration.hpp>

namespace chasles {

/// What two halves of the views say, each without the other. The halves are alternate pieces of the
/// recording, so that both have all of its motion.
struct HalvesComparison {
  /// Of each row of CamerasCalibration: the second half minus the first, and its standard
  /// deviation.
  Eigen::VectorXd difference, sigma;
  /// Of each camera over its image: root mean square of the projections' difference, and of its
  /// standard deviation [px].
  std::vector<double> pixels, pixels_sigma;
  /// Root mean square error of the corners of each half under the lenses and extrinsics of the
  /// other, each view with a pose of its own [px].
  double held_out_rms = 0;
};

/// Throws as calibrate_cameras(), where a half has too few views. The result does not depend on the
/// number of threads.
HalvesComparison compare_halves(const CamerasInput& input, int threads = 1);

/// A lens model for one camera, and how well it predicts.
struct LensTrial {
  LensForm lens;
  double held_out_rms = 0;  ///< [px], as in HalvesComparison; NaN if it has no calibration
  std::string fault;        ///< why
};

/// The lens of a camera. Each of its lenses calibrates it, by 240 views at most. All of them count
/// in each trial: where a lens has no pose for a view, the error is that of a missing corner, 10
/// px. The best is the one of fewest parameters whose error is within 1 % of the least, and which
/// the views determine together.
struct LensChoice {
  LensForm lens;
  std::vector<LensTrial> trials;
};

/// Fills `input.lenses`: of each camera the only candidate, or the best of several, and says which
/// were tried; none: there was one. `from_nothing`: the lens that a camera states is not used; nor
/// is it where there are several. The result does not depend on the number of threads. Throws
/// InputError where no lens of a camera has a calibration.
std::vector<std::optional<LensChoice>> choose_lenses(
    CamerasInput& input, const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
    int threads = 1);

/// The same, and calls `calibrate`. Where that throws UndeterminedError, the chosen lens of most
/// parameters is given up and `calibrate` called again, while there is another.
std::vector<std::optional<LensChoice>> calibrate_with_chosen_lenses(
    CamerasInput& input, const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
    int threads, const std::function<void()>& calibrate);

/// Those that are tried by default.
std::vector<LensForm> common_lenses();
/// "auto" for the common ones, or names as of lens_form() with commas between them. Throws
/// UsageError that names `setting`.
std::vector<LensForm> lens_candidates(const std::string& text, const std::string& setting);

}  // namespace chasles
