#include <cmath>

#include <nlohmann/json.hpp>

#include <chasles/session/truth_errors_json.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json rotation_json(const TruthErrors& errors, TruthErrorKind kind, Eigen::Index first) {
  Json value = Json::array(), sigma = Json::array();
  for (Eigen::Index i = first; i < first + 3; ++i) {
    value.push_back(kDegrees * errors.value[i]);
    sigma.push_back(kDegrees * errors.sigma(i));
  }
  return {{"value", value}, {"sigma", sigma}, {"significant", errors.significant(kind)}};
}

Json nees_json(const ConsistencySummary& s, double fitted_share) {
  return {{"mean", number(s.mean)},
          {"median", number(s.median)},
          {"dof", s.dof},
          {"count", s.count},
          {"skipped", s.skipped},
          {"inside", number(s.inside)},
          {"band", {s.band.low, s.band.high}},
          {"fitted_share", fitted_share}};
}

}  // namespace

Json truth_errors_json(const TruthErrors& errors) {
  return {{"position_time_s",
           {{"value", errors.value[0]},
            {"sigma", errors.sigma(0)},
            {"significant", errors.significant(TruthErrorKind::kPositionTime)}}},
          {"body_rotation_deg", rotation_json(errors, TruthErrorKind::kBodyRotation, 1)},
          {"world_rotation_deg", rotation_json(errors, TruthErrorKind::kWorldRotation, 4)},
          {"first_heading_deg",
           {{"value", kDegrees * errors.first_heading},
            {"sigma", kDegrees * errors.first_heading_sigma},
            {"significant", errors.first_heading_significant()}}},
          {"nees_position", nees_json(errors.nees.position_summary, errors.fitted_share[0])},
          {"nees_attitude", nees_json(errors.nees.attitude_summary, errors.fitted_share[1])},
          {"nees_pose", nees_json(errors.nees.pose_summary, errors.fitted_share[2])},
          {"ate_m", number(errors.rigid.position_m.rmse)},
          {"attitude_deg", number(errors.rigid.attitude_deg.rmse)},
          {"sigma_factor", errors.sigma_factor},
          {"correlation_s", errors.correlation}};
}

}  // namespace chasles
