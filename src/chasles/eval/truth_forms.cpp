#include <algorithm>
#include <array>

#include <chasles/base/constants.hpp>
#include <chasles/eval/truth_forms.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr std::array kForms{
    TruthForm{TruthReading::kAsRead, false},  TruthForm{TruthReading::kWFirst, false},
    TruthForm{TruthReading::kInverse, true},  TruthForm{TruthReading::kWFirstInverse, true},
    TruthForm{TruthReading::kInverse, false}, TruthForm{TruthReading::kWFirstInverse, false}};

constexpr double kMostWorldSigma = 0.05;  // [rad]
constexpr double kLeastExcursion = 10 * kRadians;
constexpr double kGoodAttitudes = 10 * kRadians, kError = 3 * kRadians;

// The fit with the world turned about the path by the angle that leaves least, to half a degree.
AttitudeFit best_about(const Eigen::Vector3d& axis, const Trajectory& estimate,
                       const Trajectory& truth, AttitudeFitOptions options, AttitudeFit best) {
  const Eigen::Matrix3d world = *options.truth_R_estimate;
  double centre = 0;
  for (const double step : {10 * kRadians, 2 * kRadians, 0.5 * kRadians}) {
    const double middle = centre;
    const int turns = step > 5 * kRadians ? 18 : 5;
    for (int i = -turns; i <= turns; ++i) {
      const double angle = middle + i * step;
      options.truth_R_estimate = so3::exp(angle * axis) * world;
      const auto fit = fit_attitudes(estimate, truth, options);
      if (!fit || fit->rms >= best.rms) continue;
      best = *fit;
      centre = angle;
    }
  }
  return best;
}

}  // namespace

std::optional<AttitudeFit> attitudes_on_path(const Trajectory& estimate, const Trajectory& truth,
                                             const PositionFit& path, double offset, Time gap) {
  const AttitudeFitOptions options{
      .offset = offset, .gap = gap, .truth_R_estimate = path.truth_T_estimate.R, .body = true};
  const auto fit = fit_attitudes(estimate, truth, options);
  if (!fit || world_sigma(path) < kMostWorldSigma) return fit;
  if (fit->excursion < kLeastExcursion) return std::nullopt;
  return best_about(path.axis, estimate, truth, options, *fit);
}

Trajectory in_form(const TruthForm& form, Trajectory truth) {
  if (!form.whole) return read_as(form.reading, std::move(truth));
  if (is_w_first(form.reading)) truth = read_as(TruthReading::kWFirst, std::move(truth));
  for (StampedPose& row : truth) row.pose = row.pose.inverse();
  return truth;
}

std::vector<FormFit> fit_forms(const Trajectory& estimate, const Trajectory& truth, double offset,
                               Time gap) {
  std::vector<FormFit> fits;
  for (const TruthForm& form : kForms) {
    const Trajectory poses = in_form(form, truth);
    const auto path = fit_path(estimate, poses, {.start_offset = offset, .gap = gap});
    if (!is_of_one_path(path)) continue;
    const auto attitudes = attitudes_on_path(estimate, poses, *path, offset, gap);
    if (attitudes) fits.push_back({form, *path, *attitudes});
  }
  return fits;
}

std::optional<TruthForm> contradicting_form(const std::vector<FormFit>& fits,
                                            std::optional<TruthReading> by_rates) {
  if (fits.empty()) return std::nullopt;
  const auto rms = [](const FormFit& fit) { return fit.attitudes.rms; };
  const double best = std::ranges::min(fits, {}, rms).attitudes.rms;
  if (best > kGoodAttitudes) return std::nullopt;
  for (const FormFit& fit : fits) {
    const bool stands = fit.attitudes.rms < 3 * best + kError;
    if (by_rates && fit.form.reading == *by_rates && stands) return std::nullopt;
  }
  // Of those that differ by less than errors of the estimate the simplest.
  const auto first = std::ranges::find_if(
      fits, [&](const FormFit& fit) { return fit.attitudes.rms < 2 * best + kError / 3; });
  return first->form;
}

}  // namespace chasles
