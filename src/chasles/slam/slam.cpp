#include <algorithm>
#include <chasles/slam/slam.hpp>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace chasles {
namespace {

State initial_state(const BodyVelocityModel& model) {
  State x;
  x.additive = Eigen::VectorXd::Zero(model.size());
  return x;
}

Eigen::MatrixXd initial_covariance(const Settings& s, const BodyVelocityModel& model, const Noise& noise) {
  const int n = 6 + model.size();
  Eigen::VectorXd sigma = Eigen::VectorXd::Zero(n);
  sigma.head<6>().setConstant(s.initial_pose_sigma);
  if (model.velocity_state) sigma.segment<6>(6).setConstant(100);
  if (model.gyro_bias) sigma.segment<3>(6 + model.bias_index()).setConstant(noise.gyro_bias_sigma);
  if (model.scale) sigma[6 + model.scale_index()] = s.velocity_scale_sigma;
  return sigma.cwiseAbs2().asDiagonal();
}

StereoRows rows_named(const std::string& name) {
  if (name == "all") return StereoRows::kAll;
  if (name == "mean") return StereoRows::kMean;
  return StereoRows::kMeanDisparity;
}

// chi2 quantile by Wilson–Hilferty
double chi2_quantile(double p, int k) {
  if (p >= 1) return std::numeric_limits<double>::infinity();
  double t = std::sqrt(-2*std::log(1-p));
  double z = t - (2.515517+0.802853*t+0.010328*t*t)/(1+1.432788*t+0.189269*t*t+0.001308*t*t*t);
  double a = 2.0/(9*k);
  return k*std::pow(1-a+z*std::sqrt(a),3);
}

}  // namespace

Slam::Slam(const Settings& s, const StereoRig& rig, const Noise& noise)
    : settings_(s), rig_(rig), noise_(noise),
      model_{.velocity_state = s.velocity == "measured" && s.mode == "slam", .gyro_bias = s.gyro_bias && s.mode == "slam", .scale = s.velocity_scale && s.mode == "slam"},
      rows_(rows_named(s.stereo_rows)),
      gate_(chi2_quantile(s.gate, rows_ == StereoRows::kAll ? 4 : rows_ == StereoRows::kMean ? 2 : 3)),
      loose_(chi2_quantile(s.loose_gate, rows_ == StereoRows::kAll ? 4 : rows_ == StereoRows::kMean ? 2 : 3)),
      filter_(error_chart(s.chart), initial_state(model_), initial_covariance(s, model_, noise), {.compress_map = s.compress_map}) {}

void Slam::predict_to(Time time, const BodyVelocity& held) {
  const double tau = to_seconds(time - *time_);
  if (tau > 0) filter_.propagate(predict(model_, filter_.state(), held, tau, noise_.motion));
  time_ = time;
}

void Slam::process(const BodyVelocity& u) {
  BodyVelocityNoise noise = noise_.motion;
  noise.sample_sigma.tail<3>() = (noise.sample_sigma.tail<3>().cwiseAbs2().array() + std::pow(settings_.velocity_relative_sigma * u.linear_imu.norm(), 2)).sqrt();
  if (!time_) {
    time_ = u.time;
  } else {
    BodyVelocity held = velocity_;
    if (settings_.hold == "midpoint") {
      held.linear_imu = (held.linear_imu + u.linear_imu) / 2;
      held.angular_imu = (held.angular_imu + u.angular_imu) / 2;
    }
    predict_to(u.time, held);
  }
  if (model_.velocity_state) {
    const Measurement z[] = {measure_velocity(model_, filter_.state(), u, noise)};
    filter_.update(z);
  }
  velocity_ = u;
}

UpdateReport Slam::update(const FeatureFrame& frame) {
  std::unordered_map<LandmarkId, int> index;
  const auto& landmarks = filter_.state().landmarks;
  for (std::size_t i = 0; i < landmarks.size(); ++i) index[landmarks[i].id] = static_cast<int>(i);
  std::vector<Measurement> measurements;
  StereoNoise noise = noise_.stereo;
  noise.disparity *= settings_.disparity_inflation;
  for (const StereoObservation& o : frame.observations) {
    const auto at = index.find(o.landmark);
    if (at == index.end()) continue;
    last_seen_[o.landmark] = frame_;
    auto z = measure_stereo(rig_, rows_, noise, filter_.state(), at->second, o);
    if (!z) continue;
    measurements.push_back(*z);
  }
  int inside = 0;
  for (const Measurement& z : measurements) inside += filter_.normalised_square(z) < gate_;
  for (Measurement& z : measurements) z.gate = inside >= settings_.enough ? gate_ : loose_;
  return filter_.update(measurements);
}

void Slam::retire_unseen() {
  const auto& landmarks = filter_.state().landmarks;
  std::vector<std::pair<int, int>> unseen;  // last seen, index
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const int seen = last_seen_[landmarks[i].id];
    if (seen < frame_) unseen.push_back({seen, static_cast<int>(i)});
  }
  const int excess = static_cast<int>(landmarks.size()) - settings_.waiting_landmarks;
  if (excess <= 0) return;
  std::sort(unseen.begin(), unseen.end());
  std::vector<int> indices;
  for (int i = 0; i < std::min<int>(excess, static_cast<int>(unseen.size())); ++i) indices.push_back(unseen[static_cast<std::size_t>(i)].second);
  std::sort(indices.begin(), indices.end());
  for (int i : indices) last_seen_.erase(landmarks[static_cast<std::size_t>(i)].id);
  filter_.retire(indices);
}

int Slam::begin(const FeatureFrame& frame) {
  std::unordered_set<LandmarkId> known;
  for (const Landmark& l : filter_.state().landmarks) known.insert(l.id);
  std::vector<NewLandmark> fresh;
  for (const StereoObservation& o : frame.observations) {
    if (known.count(o.landmark)) continue;
    if (o.pixels[0] - o.pixels[2] < settings_.min_disparity) continue;
    auto l = begin_landmark(rig_, noise_.stereo, filter_.state(), o);
    if (!l) continue;
    if (settings_.initial_landmark_sigma) {
      l->d_pose.setZero();
      l->noise = Eigen::Matrix3d::Identity() * *settings_.initial_landmark_sigma * *settings_.initial_landmark_sigma;
    }
    last_seen_[o.landmark] = frame_;
    fresh.push_back(*l);
  }
  filter_.add(fresh);
  return static_cast<int>(fresh.size());
}

Estimate Slam::process(const FeatureFrame& frame) {
  if (!time_) time_ = frame.time;
  if (frame.time > *time_) predict_to(frame.time, velocity_);
  ++frame_;
  Estimate e;
  if (settings_.mode != "localize") {
    if (settings_.update_with_first_observation) e.added = begin(frame);
    const UpdateReport report = update(frame);
    retire_unseen();
    if (!settings_.update_with_first_observation) e.added = begin(frame);
    e.nis = report.nis;
    e.nis_dof = report.dof;
    for (bool b : report.accepted) (b ? e.used : e.rejected)++;
  }
  e.time = frame.time;
  e.world_T_imu = filter_.state().world_T_imu;
  const Eigen::MatrixXd P = filter_.core_covariance();
  e.pose_covariance = P.topLeftCorner<6, 6>();
  e.additive = filter_.state().additive;
  e.additive_sigma = P.diagonal().tail(e.additive.size()).cwiseSqrt();
  e.observations = static_cast<int>(frame.observations.size());
  e.in_state = static_cast<int>(filter_.state().landmarks.size());
  e.landmarks = filter_.map_size();
  return e;
}

}  // namespace chasles
