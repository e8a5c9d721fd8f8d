#include <utility>

#include <chasles/base/overloaded.hpp>
#include <chasles/filter/past/history.hpp>
#include <chasles/filter/past/history_sweep_detail.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Correction = History::Correction;

std::size_t bytes_of(const MatrixXd& M) {
  return sizeof(double) * static_cast<std::size_t>(M.size());
}

std::size_t bytes_of(const History::Step& step) {
  return sizeof(History::Step) +
         std::visit(
             Overloaded{
                 [](const History::Propagation& s) { return bytes_of(s.F) + bytes_of(s.Q); },
                 [](const Correction& s) {
                   return bytes_of(s.core) + bytes_of(s.A_motion) + bytes_of(s.A_landmarks) +
                          sizeof(Correction::OfLandmark) * s.landmarks.size() +
                          sizeof(double) *
                              static_cast<std::size_t>(s.core_vector.size() + s.delta.size());
                 },
                 [](const History::Addition& s) { return bytes_of(s.d_pose) + bytes_of(s.noise); },
                 [](const History::Removal& s) {
                   return sizeof(int) * s.indices.size() + sizeof(Landmark) * s.landmarks.size();
                 },
                 [](const History::Pose&) { return std::size_t{0}; }},
             step);
}

}  // namespace

void History::append(Step step) {
  bytes_ += bytes_of(step);
  if (const auto* addition = std::get_if<Addition>(&step)) {
    state_landmarks_ += static_cast<int>(addition->d_pose.rows() / 3);
  } else if (const auto* removal = std::get_if<Removal>(&step)) {
    state_landmarks_ -= static_cast<int>(removal->indices.size());
    removed_ += static_cast<int>(removal->indices.size());
  }
  steps_.push_back(std::move(step));
}

void History::keep_bound(const Covariance& covariance) {
  if (most_bytes_ == 0) return;
  if (!middle_ && 2 * bytes_ >= most_bytes_) {
    middle_ = Middle{.steps = steps_.size(), .bytes = bytes_, .covariance = covariance.all()};
  } else if (bytes_ >= most_bytes_) {
    give_up_older_half();
  }
}

// Their landmarks are estimated from both halves.
void History::give_up_older_half() {
  const auto middle = steps_.begin() + static_cast<std::ptrdiff_t>(middle_->steps);
  std::size_t landmarks = final_.landmarks.size(), poses = final_.poses.size();
  for (auto step = steps_.begin(); step != middle; ++step) {
    if (const auto* removal = std::get_if<Removal>(&*step)) landmarks += removal->indices.size();
    poses += std::holds_alternative<Pose>(*step) ? 1 : 0;
  }
  final_ = estimates();
  final_.landmarks.resize(landmarks);
  final_.poses.resize(poses);
  steps_given_up_ += middle_->steps;
  bytes_ -= middle_->bytes;
  steps_.erase(steps_.begin(), middle);
  initial_ = std::move(middle_->covariance);
  middle_.reset();
}

Past::Estimates History::estimates() const {
  Past::Estimates result = final_;
  result.landmarks.reserve(static_cast<std::size_t>(removed_));
  const auto core = static_cast<int>(core_);
  const auto take = [&](const Removal& removal, const VectorXd& d, Covariance::ConstBlock& P) {
    for (std::size_t i = 0; i < removal.indices.size(); ++i) {
      const Landmark& landmark = removal.landmarks[i];
      const Index row = core + 3 * removal.indices[i];
      result.landmarks.push_back({.id = landmark.id,
                                  .p_world = landmark.p_world + d.segment<3>(row),
                                  .covariance = P.block<3, 3>(row, row),
                                  .observations = landmark.observations});
    }
  };
  const auto take_pose = [&](const Pose& pose, const VectorXd& d, Covariance::ConstBlock& P) {
    result.poses.push_back(corrected({.time = pose.time, .map_T_imu = pose.world_T_imu},
                                     d.head<6>(), P.topLeftCorner<6, 6>()));
  };
  filter_detail::read(core, initial_, steps_, core + 3 * state_landmarks_,
                      {.landmarks = take, .covariance = nullptr, .poses = take_pose});
  return result;
}

void History::visit_covariance(const RowVisitor& visit) const {
  filter_detail::read(static_cast<int>(core_), initial_, steps_, core_ + 3 * state_landmarks_,
                      {.landmarks = nullptr, .covariance = visit});
}

}  // namespace chasles
