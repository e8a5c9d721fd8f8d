#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/recorded_views.hpp>

namespace chasles {

/// A calibration of cameras with all that is said of it.
struct CamerasReport {
  CamerasInput input;  ///< without views
  CamerasCalibration calibration;
  std::optional<HalvesComparison> halves;          ///< none: a half is too short, see `remarks`
  std::vector<std::optional<LensChoice>> choices;  ///< of each camera; none: its lens was given
  std::vector<double> rms_before;  ///< of each camera with the lens that it states [px]; NaN: none
  std::vector<std::string> suspicious;  ///< views that the others contradict
  std::vector<std::string> missing;     ///< which views would make the result better
  std::vector<std::string> remarks;
};

/// The largest standard deviation of the projection over the image, and the root mean square [px].
struct ProjectionSummary {
  double largest = 0, rms = 0;
};
ProjectionSummary projection_summary(const CamerasCalibration& calibration, std::size_t camera);

/// Calibrates the cameras of `report.input`, and fills all the rest; remarks that are there stay.
/// `candidates`: of each camera its lens, or those of which the best is chosen. `from_nothing`: the
/// search does not begin at the lens that a camera states. The result does not depend on the number
/// of threads. Throws as calibrate_cameras() and choose_lenses().
void calibrate_with_report(CamerasReport& report,
                           const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
                           int threads = 1);

/// Of each camera with the lens that the input states, each view with the pose that is best: the
/// root mean square error of the corners [px]; NaN: it states none.
std::vector<double> rms_before(const CamerasInput& input);

/// A view with a larger root mean square error is suspicious: four times that of the median view
/// [px].
double suspicious_rms(const std::vector<ExplainedView>& views);
/// A sentence where the views are few independent pieces; empty: they are enough.
std::string few_pieces(int pieces);
/// A sentence on each suspicious view.
std::vector<std::string> suspicious_views(const std::vector<ExplainedView>& views);
/// What the views do not show (ViewCoverage::missing). `input`: the sizes and the corners.
std::vector<std::string> missing_views(const CamerasInput& input,
                                       const std::vector<ExplainedView>& views);
/// u, v [px] and the uncertainty of the projection there [px, rad], of a grid of the image.
nlohmann::ordered_json projection_json(const Camera& camera, const Eigen::MatrixXd& covariance);
/// The lenses that were tried for a camera.
nlohmann::ordered_json trials_json(const LensChoice& choice);

/// The content of cameras.json (docs/calibration.md).
nlohmann::ordered_json cameras_json(const CamerasReport& report);
/// The table of the terminal.
std::string cameras_text(const CamerasReport& report);

}  // namespace chasles
