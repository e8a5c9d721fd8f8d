#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/report/calibration_page.hpp>

namespace chasles::test {

/// As cameras.json has two cameras of 640 x 480 px, with 5 parameters. The halves differ by 4 sigma
/// in "cam1.fx".
nlohmann::ordered_json two_cameras_json();

/// 40 views of each camera by turns, a tenth of a second apart, of 36 corners that leave the right
/// of the images empty. The seventh view is suspicious.
std::vector<CalibrationView> synthetic_views();

}  // namespace chasles::test
