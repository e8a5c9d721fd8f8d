#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <chasles/report/calibration_page_testing.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace test {

nlohmann::ordered_json two_cameras_json() {
  using Json = nlohmann::ordered_json;
  Json grid = Json::array();
  for (int j = 0; j < 11; ++j) {
    for (int i = 0; i < 17; ++i) {
      const double u = 639.0 * i / 16, v = 479.0 * j / 10;
      const double sigma = 0.05 + 1e-6 * (std::pow(u - 320, 2) + std::pow(v - 240, 2));
      grid.push_back({u, v, sigma, sigma / 400});
    }
  }
  Json cameras = Json::array();
  for (int c = 0; c < 2; ++c) {
    cameras.push_back(
        {{"lens", "radtan"},
         {"resolution", {640, 480}},
         {"cam_T_cam0", {{1, 0, 0, -0.1 * c}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}},
         {"views", 40},
         {"corners", 1440},
         {"rms_px", 0.2},
         {"rms_before_px", c == 0 ? Json(0.4) : Json()},
         {"projection", {{"grid", grid}}},
         {"halves_px", 0.1},
         {"halves_sigma_px", 0.1}});
  }
  cameras[0]["lenses"] = {{{"lens", "radtan"}, {"held_out_rms_px", 0.2}, {"fault", ""}},
                          {{"lens", "ds"}, {"held_out_rms_px", nullptr}, {"fault", "no result"}}};
  Json parameters = Json::array(), covariance = Json::array();
  for (const char* name : {"cam0.fx", "cam0.fy", "cam1.fx", "cam1.fy", "cam1.rotation_x"}) {
    const double sigma = 0.5;
    const bool differs = std::string(name) == "cam1.fx";
    Json row = Json::array();
    for (std::size_t j = 0; j < 5; ++j) row.push_back(j == covariance.size() ? 0.25 : -0.1);
    covariance.push_back(row);
    parameters.push_back({{"name", name},
                          {"value", 400.25},
                          {"unit", "px"},
                          {"sigma", sigma},
                          {"halves_difference", differs ? 4.0 : 0.5},
                          {"halves_sigma", 1.0}});
  }
  return {{"pixel_sigma_px", 0.2},
          {"correlation_factor", 2.25},
          {"views", 80},
          {"views_without_pose", 1},
          {"cameras", cameras},
          {"parameters", parameters},
          {"covariance", covariance},
          {"suspicious", {"cam0 at 100.300 s: 3 px"}},
          {"missing", Json::array()},
          {"remarks", Json::array()},
          {"held_out_rms_px", 0.25}};
}

std::vector<CalibrationView> synthetic_views() {
  std::vector<CalibrationView> views;
  for (int k = 0; k < 80; ++k) {
    CalibrationView view{.seconds = 100 + 0.1 * (k / 2),
                         .camera = k % 2,
                         .is_suspicious = k == 6,
                         .rms = k == 6 ? 3 : 0.2 + 0.002 * k,
                         .pixels = {},
                         .errors = {}};
    for (int i = 0; i < 36; ++i) {
      view.pixels.emplace_back(20 + 70 * (i % 6) + k, 15 + 75 * (i / 6) + k % 13);
      view.errors.emplace_back(0.2 * std::sin(i + k), 0.2 * std::cos(i * k));
    }
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace test

namespace {

using test::column;

double sum_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}

TEST(CalibrationPage, PartsOfTheImageHaveAllCornersAndTheirMeanErrors) {
  auto views = test::synthetic_views();
  // Corners beyond the image count in the part next to them.
  views[0].pixels[0] = {-3, -40};
  views[0].errors[0] = {1000, -500};
  const auto data = test::data_of(cameras_page(test::two_cameras_json(), views));
  const auto& cells = data["cameras"][0]["cells"];
  EXPECT_EQ(cells["columns"], 24);
  EXPECT_EQ(cells["rows"], 18);
  const auto counts = column(cells["figures"]["corners"]), du = column(cells["figures"]["du"]),
             dv = column(cells["figures"]["dv"]);
  ASSERT_EQ(counts.size(), 24U * 18U);
  EXPECT_EQ(sum_of(counts), 40 * 36);
  // Those of three other views lie in the first part.
  ASSERT_EQ(counts[0], 4);
  Eigen::Vector2d sum(1000, -500);
  for (const std::size_t view : {2U, 4U, 6U}) sum += views[view].errors[0];
  EXPECT_NEAR(du[0], sum.x() / 4, 1e-4);
  EXPECT_NEAR(dv[0], sum.y() / 4, 1e-4);
  EXPECT_EQ(counts[23], 0);
  EXPECT_EQ(du[23], 0);
}

TEST(CalibrationPage, OfManyCornersSomeThousandsAreDrawn) {
  auto views = test::synthetic_views();
  for (CalibrationView& view : views) {
    for (int i = 0; i < 1000; ++i) {
      view.pixels.emplace_back(i % 640, i % 480);
      view.errors.emplace_back(0.1, -0.1);
    }
  }
  const auto data = test::data_of(cameras_page(test::two_cameras_json(), views));
  const auto drawn = column(data["cameras"][1]["corners"]["u"]).size();
  EXPECT_GT(drawn, 2000U);
  EXPECT_LE(drawn, 5000U);
  EXPECT_EQ(sum_of(column(data["cameras"][1]["cells"]["figures"]["corners"])), 40 * 1036);
}

TEST(CalibrationPage, ViewsHaveTheirTimesAndErrors) {
  const auto views = test::synthetic_views();
  const auto data = test::data_of(cameras_page(test::two_cameras_json(), views));
  const auto& figures = data["views"]["figures"];
  EXPECT_EQ(data["views"]["first_s"], 100);
  const auto seconds = column(figures["seconds"]), suspicious = column(figures["suspicious"]);
  ASSERT_EQ(seconds.size(), 80U);
  EXPECT_NEAR(seconds[79], 3.9, 1e-6);
  EXPECT_EQ(sum_of(suspicious), 1);
  EXPECT_EQ(suspicious[6], 1);
  EXPECT_NEAR(column(figures["rms"])[79], views[79].rms, 1e-6);
}

}  // namespace
}  // namespace chasles
