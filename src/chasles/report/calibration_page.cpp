#include <algorithm>
#include <cmath>

#include <chasles/report/calibration_page.hpp>
#include <chasles/report/columns.hpp>
#include <chasles/report/page_template.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kCellColumns = 24;
constexpr std::size_t kDrawnCorners = 5000;  // of each camera

struct PageCorner {
  Eigen::Vector2d pixel, error;
};

std::vector<PageCorner> corners_of(std::span<const CalibrationView> views, int camera) {
  std::vector<PageCorner> corners;
  for (const CalibrationView& view : views) {
    if (view.camera != camera) continue;
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      corners.push_back({view.pixels[i], view.errors[i]});
    }
  }
  return corners;
}

struct ImageCell {
  int corners = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();  // of the errors
};

// How many corners each part of the image has, and their mean error.
Json cells_json(const std::vector<PageCorner>& corners, double width, double height) {
  const int rows = std::max(1, static_cast<int>(std::lround(kCellColumns * height / width)));
  std::vector<ImageCell> cells(static_cast<std::size_t>(kCellColumns * rows));
  for (const PageCorner& corner : corners) {
    const int i = static_cast<int>(kCellColumns * (corner.pixel.x() + 0.5) / width);
    const int j = static_cast<int>(rows * (corner.pixel.y() + 0.5) / height);
    ImageCell& cell = cells[static_cast<std::size_t>(std::clamp(j, 0, rows - 1) * kCellColumns +
                                                     std::clamp(i, 0, kCellColumns - 1))];
    ++cell.corners;
    cell.sum += corner.error;
  }
  const auto mean = [](int axis) {
    return [axis](const ImageCell& cell) { return cell.sum[axis] / std::max(1, cell.corners); };
  };
  return {{"columns", kCellColumns},
          {"rows", rows},
          {"figures",
           {{"corners", ints(cells, [](const ImageCell& cell) { return cell.corners; })},
            {"du", floats(cells, mean(0))},
            {"dv", floats(cells, mean(1))}}}};
}

Json drawn_json(const std::vector<PageCorner>& corners) {
  const std::vector<PageCorner> drawn = thinned(corners, kDrawnCorners);
  return {{"u", floats(drawn, [](const PageCorner& corner) { return corner.pixel.x(); })},
          {"v", floats(drawn, [](const PageCorner& corner) { return corner.pixel.y(); })},
          {"du", floats(drawn, [](const PageCorner& corner) { return corner.error.x(); })},
          {"dv", floats(drawn, [](const PageCorner& corner) { return corner.error.y(); })}};
}

Json views_json(std::span<const CalibrationView> views) {
  const double first = views.empty() ? 0 : views.front().seconds;
  return {
      {"first_s", first},
      {"figures",
       {{"seconds",
         floats(views, [&](const CalibrationView& view) { return view.seconds - first; })},
        {"camera", ints(views, [](const CalibrationView& view) { return view.camera; })},
        {"rms", floats(views, [](const CalibrationView& view) { return view.rms; })},
        {"corners",
         ints(views,
              [](const CalibrationView& view) { return static_cast<int>(view.pixels.size()); })},
        {"suspicious",
         ints(views, [](const CalibrationView& view) { return view.is_suspicious ? 1 : 0; })}}}};
}

}  // namespace

std::string cameras_page(const Json& calibration, std::span<const CalibrationView> views) {
  Json cameras = Json::array();
  for (const Json& camera : calibration.at("cameras")) {
    const auto corners = corners_of(views, static_cast<int>(cameras.size()));
    const Json& size = camera.at("resolution");
    cameras.push_back(
        {{"cells", cells_json(corners, size.at(0), size.at(1))}, {"corners", drawn_json(corners)}});
  }
  return with_data(calibration_template, {{"kind", "cameras"},
                                          {"calibration", calibration},
                                          {"cameras", cameras},
                                          {"views", views_json(views)}});
}

std::string noise_page(const Json& noise, std::span<const AllanCurve> curves) {
  Json list = Json::array();
  for (const AllanCurve& curve : curves) {
    list.push_back({{"sensor", curve.sensor},
                    {"axis", curve.axis},
                    {"points",
                     {{"seconds", float_column(curve.seconds)},
                      {"deviation", float_column(curve.deviation)},
                      {"lowest", float_column(curve.lowest)},
                      {"highest", float_column(curve.highest)},
                      {"of_fit", float_column(curve.of_fit)}}}});
  }
  return with_data(calibration_template, {{"kind", "noise"}, {"noise", noise}, {"curves", list}});
}

}  // namespace chasles
