#include <algorithm>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include <chasles/report/columns.hpp>
#include <chasles/report/page_images.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;
using Images = std::vector<const ShownImage*>;

// Selects whole frames: all cameras of an instant.
Images within(const std::vector<ShownImage>& images, std::size_t most) {
  std::size_t bytes = 0;
  std::set<Time> times;
  for (const ShownImage& image : images) {
    bytes += image.jpeg.size();
    times.insert(image.time);
  }
  const std::size_t stride = bytes / std::max<std::size_t>(most, 1) + 1;
  std::set<Time> kept;
  std::size_t at = 0;
  for (const Time time : times) {
    if (at++ % stride == 0) kept.insert(time);
  }
  Images result;
  for (const ShownImage& image : images) {
    if (kept.contains(image.time)) result.push_back(&image);
  }
  return result;
}

// A number that is not representable as an integer becomes 0.
int whole(double value, double unit) {
  const double steps = std::round(value / unit);
  return std::abs(steps) < 1e9 ? static_cast<int>(steps) : 0;
}

// Of an ellipse: standard deviations and correlation, in hundredths.
struct Shape {
  int sigma_u = 0, sigma_v = 0, correlation = 0;
};

Shape shape(const ImageFeature& f) {
  if (!f.seen.expected) return {};
  const Eigen::Matrix2d& S = f.seen.expected->covariance;
  const double u = std::sqrt(S(0, 0)), v = std::sqrt(S(1, 1));
  return {.sigma_u = whole(u, 0.01),
          .sigma_v = whole(v, 0.01),
          .correlation = whole(S(0, 1) / (u * v), 0.01)};
}

void add_features(Json& json, const std::vector<const ImageFeature*>& features) {
  const auto add = [&](const char* name, const auto& of) {
    json[name] = ints(features, [&](const ImageFeature* f) -> int { return of(*f); });
  };
  const auto pixel = [](const ImageFeature& f) { return f.seen.observation.pixel; };
  json["id"] = double_column(values<double>(features, [](const ImageFeature* f) {
    return static_cast<double>(f->seen.observation.landmark);
  }));
  add("age", [](const ImageFeature& f) { return f.age; });
  add("outcome", [](const ImageFeature& f) { return static_cast<int>(f.seen.outcome); });
  for (const auto& [axis, k] : {std::pair{"u", 0}, {"v", 1}}) {
    const auto to = [&pixel, k = k](const ImageFeature& f, const Eigen::Vector2d& p) {
      return whole(p(k) - pixel(f)(k), 0.01);
    };
    add(axis, [&pixel, k = k](const ImageFeature& f) { return whole(pixel(f)(k), 0.1); });
    add(k == 0 ? "before_u" : "before_v",
        [&](const ImageFeature& f) { return f.before ? to(f, *f.before) : 0; });
    add(k == 0 ? "expected_u" : "expected_v",
        [&](const ImageFeature& f) { return f.seen.expected ? to(f, f.seen.expected->pixel) : 0; });
  }
  add("sigma_u", [](const ImageFeature& f) { return shape(f).sigma_u; });
  add("sigma_v", [](const ImageFeature& f) { return shape(f).sigma_v; });
  add("correlation", [](const ImageFeature& f) { return shape(f).correlation; });
}

Json camera_json(const Images& images, Time start) {
  Json json = {{"width", images.front()->width}, {"height", images.front()->height}};
  json["t"] = floats(images, [&](const ShownImage* i) { return to_seconds(i->time - start); });
  json["jpeg"] = Json::array();
  std::vector<const ImageFeature*> features;
  for (const ShownImage* image : images) {
    json["jpeg"].push_back(base64({image->jpeg.begin(), image->jpeg.end()}));
    for (const ImageFeature& f : image->features) features.push_back(&f);
  }
  json["count"] =
      ints(images, [](const ShownImage* i) { return static_cast<int>(i->features.size()); });
  add_features(json, features);
  return json;
}

}  // namespace

Json images_json(const Run& run, std::size_t most) {
  Json json = Json::array();
  if (run.states.empty()) return json;
  const Images all = within(run.images, most);
  std::set<int> cameras;
  for (const ShownImage* image : all) cameras.insert(image->camera);
  for (const int camera : cameras) {
    Images own;
    std::ranges::copy_if(all, std::back_inserter(own),
                         [&](const ShownImage* i) { return i->camera == camera; });
    json.push_back(camera_json(own, run.states.front().time));
    json.back()["camera"] = camera;
  }
  return json;
}

}  // namespace chasles
