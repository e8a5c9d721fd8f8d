#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/lens_parameters.hpp>
#include <chasles/calibrate/levenberg_marquardt.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array<double, 5> kFirstOmni = {1, 0, 0, 0, 0};

// From where a search of each model finds the others. A double sphere has two minima.
std::vector<LensCoefficients> first_coefficients(const LensForm& form) {
  const std::size_t n = form.coefficients;
  switch (form.distortion) {
    case Distortion::kDoubleSphere:
      return {{-0.25, 0.6}, {0.4, 0.5}};
    case Distortion::kEucm:
      return {{0.5, 1.0}};
    case Distortion::kOmni:
      return {LensCoefficients(std::span(kFirstOmni).first(n))};
    case Distortion::kFov:
      return {{1.0}};
    case Distortion::kDivision:
      return {{-0.1}};
    default:
      return {LensCoefficients(std::vector<double>(n, 0.0))};
  }
}

struct LensStep {
  VectorXd d;
  double decrease = 0;
};

struct LensEquations {
  MatrixXd H;
  VectorXd g;
  double cost = 0;

  std::optional<LensStep> solve(double damping) const {
    MatrixXd damped = H;
    damped.diagonal() *= 1 + damping;
    const VectorXd d = -damped.ldlt().solve(g);
    if (!d.allFinite()) return std::nullopt;
    return LensStep{d, (damping * d.dot(H.diagonal().cwiseProduct(d)) - g.dot(d)) / 2};
  }
};

std::optional<LensEquations> lens_equations(const Camera& camera,
                                            const std::vector<PixelDirection>& directions) {
  const int n = form_of(camera).parameters();
  LensEquations e{MatrixXd::Zero(n, n), VectorXd::Zero(n), 0};
  const LensForm form = form_of(camera);
  const MatrixXd by_coordinates =
      by_search_coordinates(form, search_coordinates(form, lens_parameters(camera)));
  for (const PixelDirection& one : directions) {
    const auto image = project(camera, one.bearing);
    if (!image) return std::nullopt;
    const Eigen::Vector2d r = image->pixel - one.pixel;
    const MatrixXd J = *parameter_derivative(camera, one.bearing) * by_coordinates;
    e.H.noalias() += J.transpose() * J;
    e.g.noalias() += J.transpose() * r;
    e.cost += r.squaredNorm() / 2;
  }
  return e;
}

std::optional<std::pair<double, Camera>> fitted_lens(
    const Camera& like, const LensForm& form, const LensCoefficients& first,
    const std::vector<PixelDirection>& directions) {
  Camera start = like;
  start.distortion = form.distortion;
  start.coefficients = first;
  const Eigen::Vector2d on_axis = focal_lengths_at_axis(like);
  const Eigen::Vector2d of_start = focal_lengths_at_axis(start);
  start.fx *= on_axis.x() / of_start.x();
  start.fy *= on_axis.y() / of_start.y();
  std::vector<PixelDirection> usable;
  const double least_z = sees_beside(start) ? -1 : std::cos(80 * kRadians);
  std::ranges::copy_if(directions, std::back_inserter(usable), [&](const PixelDirection& one) {
    return one.bearing.z() > least_z && project(start, one.bearing);
  });
  if (static_cast<int>(usable.size()) < form.parameters()) return std::nullopt;
  const auto found = minimised(
      start, [&](const Camera& camera) { return lens_equations(camera, usable); },
      [](const Camera& camera, const LensStep& step) { return moved(camera, step.d); });
  if (!found) return std::nullopt;
  return std::pair(found->linearised.cost / static_cast<double>(usable.size()), found->state);
}

bool has_xi(const LensForm& form) {
  return form.distortion == Distortion::kDoubleSphere || form.distortion == Distortion::kOmni;
}

// Pixels of a unit angle on the axis, over the focal length.
double slope_on_axis(const LensForm& form, const VectorXd& parameters) {
  return has_xi(form) ? 1 / (1 + parameters[4]) : 1;
}

bool is_long_omni(const LensForm& form) {
  return form.distortion == Distortion::kOmni && form.coefficients == 5;
}

// A double sphere has the radius (a + third a^3 + ...) / (1 + xi) at the angle a.
double third_of_spheres(double xi, double alpha) {
  const double u = 1 + xi;
  return 1 / (2 * u) - 1.0 / 6 - alpha / (2 * u * u);
}

double alpha_of_spheres(double xi, double third) {
  const double u = 1 + xi;
  return u - u * u * (1.0 / 3 + 2 * third);
}

// sin a / (cos a + xi) = s (a + third a^3 + fifth a^5 + ...), s = 1 / (1 + xi).
struct OmniSeries {
  double third, fifth;
  explicit OmniSeries(double s) : third(s / 2 - 1.0 / 6), fifth(s * s / 4 - s / 8 + 1.0 / 120) {}
};

}  // namespace

LensForm lens_form(const std::string& text, const std::string& setting) {
  const std::size_t colon = text.find(':');
  const std::optional<Distortion> distortion = lens_model_named(text.substr(0, colon));
  if (!distortion) {
    throw UsageError(fmt::format("{}: found '{}', expected one of {}, as radtan or radtan:8",
                                 setting, text, lens_model_names()));
  }
  const LensModel& model = *find_lens_model(*distortion);
  LensForm form{*distortion, model.counts[0]};
  if (colon == std::string::npos) return form;
  const std::string number = text.substr(colon + 1);
  const auto [end, fault] =
      std::from_chars(number.data(), number.data() + number.size(), form.coefficients);
  const bool is_known = std::ranges::any_of(
      model.counts, [&](std::uint8_t count) { return count > 0 && count == form.coefficients; });
  if (fault != std::errc{} || end != number.data() + number.size() || !is_known) {
    std::vector<int> counts;
    for (const std::uint8_t count : model.counts) {
      if (count > 0) counts.push_back(count);
    }
    throw UsageError(fmt::format("{}: found '{}', expected one of {} coefficients of {}", setting,
                                 text, fmt::join(counts, ", "), model.name));
  }
  return form;
}

std::string name_of(const LensForm& form) {
  const LensModel& model = *find_lens_model(form.distortion);
  if (form.coefficients == model.counts[0]) return std::string(model.name);
  return fmt::format("{}:{}", model.name, form.coefficients);
}

LensForm form_of(const Camera& camera) { return {camera.distortion, camera.coefficients.size()}; }

VectorXd lens_parameters(const Camera& camera) {
  VectorXd parameters(form_of(camera).parameters());
  parameters.head<4>() << camera.fx, camera.fy, camera.cx, camera.cy;
  for (std::size_t i = 0; i < camera.coefficients.size(); ++i) {
    parameters[4 + static_cast<Eigen::Index>(i)] = camera.coefficients[i];
  }
  return parameters;
}

std::vector<std::string> lens_parameter_names(const LensForm& form) {
  std::vector<std::string> names = {"fx", "fy", "cx", "cy"};
  const std::vector<std::string> all = coefficient_names(form.distortion);
  names.insert(names.end(), all.begin(),
               all.begin() + static_cast<std::ptrdiff_t>(form.coefficients));
  return names;
}

std::optional<Camera> moved(const Camera& camera, const VectorXd& coordinates) {
  const LensForm form = form_of(camera);
  return with_lens_parameters(
      camera, from_search_coordinates(
                  form, search_coordinates(form, lens_parameters(camera)) + coordinates));
}

std::optional<Camera> with_lens_parameters(Camera camera, const VectorXd& parameters) {
  camera.fx = parameters[0], camera.fy = parameters[1];
  camera.cx = parameters[2], camera.cy = parameters[3];
  const std::vector<double> coefficients(parameters.data() + 4,
                                         parameters.data() + parameters.size());
  camera.coefficients = LensCoefficients(coefficients);
  const LensModel& model = *find_lens_model(camera.distortion);
  if (!parameters.allFinite() || camera.fx <= 0 || camera.fy <= 0 ||
      (model.is_within != nullptr && !model.is_within(camera.coefficients))) {
    return std::nullopt;
  }
  return camera;
}

VectorXd search_coordinates(const LensForm& form, const VectorXd& parameters) {
  VectorXd c = parameters;
  c.head<2>() *= slope_on_axis(form, parameters);
  if (form.distortion == Distortion::kDoubleSphere) c[5] = third_of_spheres(c[4], c[5]);
  if (!is_long_omni(form)) return c;
  const double s = 1 / (1 + parameters[4]);
  const OmniSeries series(s);
  const double k1 = parameters[5] * s * s, k2 = parameters[6] * s * s * s * s;
  c[5] = series.third + k1;
  c[6] = series.fifth + 3 * k1 * series.third + k2;
  c.tail<2>() *= s;
  return c;
}

VectorXd from_search_coordinates(const LensForm& form, const VectorXd& coordinates) {
  VectorXd p = coordinates;
  p.head<2>() /= slope_on_axis(form, coordinates);
  if (form.distortion == Distortion::kDoubleSphere) p[5] = alpha_of_spheres(p[4], p[5]);
  if (!is_long_omni(form)) return p;
  const double s = 1 / (1 + coordinates[4]);
  const OmniSeries series(s);
  const double k1 = coordinates[5] - series.third;
  const double k2 = coordinates[6] - series.fifth - 3 * k1 * series.third;
  p[5] = k1 / (s * s);
  p[6] = k2 / (s * s * s * s);
  p.tail<2>() /= s;
  return p;
}

MatrixXd by_search_coordinates(const LensForm& form, const VectorXd& coordinates) {
  MatrixXd J = MatrixXd::Identity(coordinates.size(), coordinates.size());
  if (!has_xi(form)) return J;
  const double u = 1 + coordinates[4];
  J(0, 0) = J(1, 1) = u;
  J.block<2, 1>(0, 4) = coordinates.head<2>();
  if (form.distortion == Distortion::kDoubleSphere) {
    J(5, 5) = -2 * u * u;
    J(5, 4) = 1 - u * (2.0 / 3 + 4 * coordinates[5]);
  }
  if (!is_long_omni(form)) return J;
  const OmniSeries series(1 / u);
  const double d_third = -1 / (2 * u * u), d_fifth = -1 / (2 * u * u * u) + 1 / (8 * u * u);
  const double k1 = coordinates[5] - series.third;
  const double k2 = coordinates[6] - series.fifth - 3 * k1 * series.third;
  J(5, 5) = u * u;
  J(5, 4) = 2 * u * k1 - u * u * d_third;
  J(6, 6) = u * u * u * u;
  J(6, 5) = -3 * series.third * J(6, 6);
  J(6, 4) = 4 * u * u * u * k2 + J(6, 6) * (3 * d_third * (series.third - k1) - d_fifth);
  J(7, 7) = J(8, 8) = u;
  J.block<2, 1>(7, 4) = coordinates.tail<2>();
  return J;
}

std::vector<LensPrior> lens_priors(const LensForm& form) {
  switch (form.distortion) {
    case Distortion::kDoubleSphere:  // published ones are between -0.3 and 0.4
      return {{.parameter = 4, .mean = 0, .sigma = 0.5}};
    case Distortion::kOmni:  // a lens has 0.5 to 3, a parabolic mirror 1
      return {{.parameter = 4, .mean = 1.5, .sigma = 1}};
    case Distortion::kRadtan:
      if (form.coefficients < 8) return {};
      return {{.parameter = 9, .mean = 0, .sigma = 2},  // k4, k5, k6
              {.parameter = 10, .mean = 0, .sigma = 2},
              {.parameter = 11, .mean = 0, .sigma = 2}};
    default:
      return {};
  }
}

std::vector<Camera> fitted_lenses(const Camera& like, const LensForm& form,
                                  const std::vector<PixelDirection>& directions) {
  std::vector<std::pair<double, Camera>> found;
  for (const LensCoefficients& first : first_coefficients(form)) {
    if (const auto lens = fitted_lens(like, form, first, directions)) found.push_back(*lens);
  }
  std::ranges::stable_sort(found, {}, [](const auto& one) { return one.first; });
  std::vector<Camera> cameras;
  for (auto& [cost, camera] : found) cameras.push_back(std::move(camera));
  return cameras;
}

}  // namespace chasles
