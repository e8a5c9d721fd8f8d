#include <algorithm>
#include <utility>

#include <chasles/estimate/landmark_records.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/loop_matching.hpp>

namespace chasles {
namespace {

constexpr double kKnownDepth = 0.2;  // relative sigma, for the size of a patch
// Landmarks that are compared at a time, and observations for each of them.
constexpr std::size_t kMostLandmarks = 25, kMostSimilar = 3;
// How far from its expected place a landmark may look similar, as a part of the image's width. What
// is possible is decided with its covariance, later.
constexpr double kFarthestSimilar = 0.3;
constexpr double kJointProbability = 0.95;
constexpr int kLeastConfirmed = 4;
constexpr double kLeastParallax = 0.02;  // [rad]
// Landmarks return where they contain so much information [nat]: each of them given the others, and
// together.
constexpr double kLeastEach = 0.2, kLeastTogether = 3;

// A wrong match is compatible with the right ones by chance, and from another place no longer.
std::vector<int> confirmed_matches(const std::vector<int>& joint,
                                   const LoopInnovations& innovations,
                                   const std::vector<LoopCandidate>& candidates,
                                   const std::vector<ObservedLandmark>& observed,
                                   const Eigen::Vector3d& p_nav, CompatibleMatches& compatible) {
  CompatibleMatches now;
  std::vector<int> confirmed;
  for (const int i : joint) {
    const ProposedMatch& match = innovations.matches[static_cast<std::size_t>(i)];
    const LoopCandidate& candidate = candidates[static_cast<std::size_t>(match.landmark)];
    const std::pair key(observed[static_cast<std::size_t>(match.observation)].id, candidate.id);
    const auto before = compatible.find(key);
    const Eigen::Vector3d first = before == compatible.end() ? p_nav : before->second;
    const double parallax = (p_nav - first).norm() / (candidate.past->p_nav - p_nav).norm();
    if (parallax >= kLeastParallax) confirmed.push_back(i);
    now.emplace(key, first);
  }
  compatible = std::move(now);
  return confirmed;
}

}  // namespace

SE3 nav_T_camera(std::span<const Camera> cameras, const State& x, int index) {
  const Camera camera = as_estimated(cameras[static_cast<std::size_t>(index)], x, index);
  const SE3 world_T_cam = x.world_T_imu * camera.cam_T_imu.inverse();
  return x.nav_T_world ? *x.nav_T_world * world_T_cam : world_T_cam;
}

std::vector<ObservedLandmark> observed_landmarks(
    Describer& describer, std::span<const Camera> cameras, const Ekf& filter,
    const GrayImage& image, const std::vector<const PixelObservation*>& observations) {
  const State& x = filter.state();
  const SE3 nav_T_cam = nav_T_camera(cameras, x, 0);
  const SE3 cam_T_world =
      x.nav_T_world ? nav_T_cam.inverse() * *x.nav_T_world : nav_T_cam.inverse();
  std::vector<ObservedLandmark> seen;
  std::vector<ImagePatch> patches;
  LandmarkIndex indices;
  indices.set(x);
  for (const PixelObservation* o : observations) {
    const auto number = o->camera == 0 ? indices.find(o->landmark) : std::nullopt;
    if (!number) continue;
    const Landmark& landmark = x.landmarks[static_cast<std::size_t>(*number)];
    const bool known =
        landmark.has_place() && (!landmark.anchor || filter.inverse_depth_sigma(landmark) <
                                                         kKnownDepth * landmark.inverse_depth.z());
    if (!known) continue;
    auto found = view_patches(cameras.front(), nav_T_cam.R, cam_T_world * x.p_world(landmark));
    if (!found) continue;
    for (ImagePatch& patch : found->patches) patch.centre = o->pixel;
    patches.insert(patches.end(), found->patches.begin(), found->patches.end());
    seen.push_back({.id = o->landmark, .index = *number, .pixel = o->pixel, .view = found->view});
  }
  const auto descriptors = describer.describe(image, patches);
  std::vector<ObservedLandmark> described;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto first = descriptors.begin() + static_cast<std::ptrdiff_t>(i * PatchView::kLevels);
    if (!std::all_of(first, first + PatchView::kLevels,
                     [](const auto& d) { return d.has_value(); }))
      continue;
    for (std::size_t k = 0; k < PatchView::kLevels; ++k) {
      seen[i].view.descriptors[k] = *first[static_cast<std::ptrdiff_t>(k)];
    }
    described.push_back(seen[i]);
  }
  return described;
}

std::vector<LoopCandidate> similar_landmarks(std::span<const Camera> cameras, const State& x,
                                             PastLandmarks& past,
                                             const std::vector<ObservedLandmark>& observed) {
  const SE3 nav_T_cam = nav_T_camera(cameras, x, 0), cam_T_nav = nav_T_cam.inverse();
  const Camera& camera = cameras.front();
  const double reach = kFarthestSimilar * camera.width;
  std::vector<LoopCandidate> candidates;
  for (auto& [id, landmark] : past) {
    const auto expected = view_patches(camera, nav_T_cam.R, cam_T_nav * landmark.p_nav);
    if (!expected || !in_image(camera, expected->patches.front().centre, -reach) ||
        !landmark.appearance.may_match(expected->view)) {
      continue;
    }
    LoopCandidate candidate{.id = id, .past = &landmark};
    for (std::size_t i = 0; i < observed.size(); ++i) {
      if ((observed[i].pixel - expected->patches.front().centre).norm() > reach) continue;
      const auto distance = landmark.appearance.distance(observed[i].view);
      if (distance && *distance <= kSimilarBits) {
        candidate.like.emplace_back(*distance, static_cast<int>(i));
      }
    }
    if (candidate.like.empty()) continue;
    std::ranges::sort(candidate.like);
    if (candidate.like.size() > kMostSimilar) candidate.like.resize(kMostSimilar);
    candidates.push_back(std::move(candidate));
  }
  std::ranges::stable_sort(candidates, {},
                           [](const LoopCandidate& c) { return c.like.front().first; });
  if (candidates.size() > kMostLandmarks) candidates.resize(kMostLandmarks);
  std::ranges::sort(candidates, {}, [](const LoopCandidate& c) { return c.past->number; });
  return candidates;
}

KnownLandmarks known_landmarks(const Ekf& filter, const std::vector<LoopCandidate>& candidates) {
  std::vector<int> numbers;
  for (const LoopCandidate& c : candidates) numbers.push_back(c.past->number);
  Carried past = filter.recall(numbers);
  KnownLandmarks known{
      .landmarks = {}, .C = std::move(past.C), .P = std::move(past.P), .by_place = {}};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    known.landmarks.push_back(filter.past().landmark(numbers[i]));
    known.landmarks.back().p_world += past.correction.segment<3>(3 * static_cast<Eigen::Index>(i));
  }
  return known;
}

LoopInnovations loop_innovations(const Camera& camera, const Ekf& filter,
                                 std::vector<LoopCandidate>& candidates,
                                 const KnownLandmarks& known,
                                 const std::vector<ObservedLandmark>& observed) {
  using Eigen::Index;
  using Eigen::Matrix3d;
  using Eigen::MatrixXd;
  const Index n = filter.covariance().rows(), k = known.P.rows();
  // A state in which the past landmarks follow the filter's own errors.
  State x = filter.state();
  x.landmarks.clear();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Index at = 3 * static_cast<Index>(i);
    Landmark landmark = known.landmarks[i];
    landmark.row = static_cast<int>(n + at);
    candidates[i].past->p_nav = landmark.p_world;
    if (x.nav_T_world) landmark.p_world = x.nav_T_world->inverse() * landmark.p_world;
    x.landmarks.push_back(landmark);
  }
  LoopInnovations result;
  std::vector<Measurement> measurements;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (const auto& [distance, index] : candidates[i].like) {
      const ObservedLandmark& s = observed[static_cast<std::size_t>(index)];
      const auto z = measure_pixel(camera, 1, x, static_cast<int>(i), s.pixel);
      if (!z) continue;
      result.matches.push_back({.observation = index, .landmark = static_cast<int>(i)});
      measurements.push_back(*z);
    }
  }
  const auto m = static_cast<Index>(measurements.size());
  MatrixXd H = MatrixXd::Zero(2 * m, n + k);
  result.r.resize(2 * m);
  result.by_place = MatrixXd::Zero(2 * m, known.by_place.cols());
  for (Index i = 0; i < m; ++i) {
    const Measurement& z = measurements[static_cast<std::size_t>(i)];
    const Landmark& landmark = x.landmarks[static_cast<std::size_t>(z.landmark)];
    result.r.segment<2>(2 * i) = z.residual;
    auto rows = H.middleRows<2>(2 * i);
    rows.middleCols(z.core_column, z.d_core.cols()) += z.d_core;
    for (const auto& of_camera : z.clones) rows.middleCols<6>(of_camera.row) += of_camera.d;
    // The past landmark is in nav axes.
    const Matrix3d nav_R_world = x.nav_T_world ? x.nav_T_world->R : Matrix3d::Identity();
    const Eigen::Matrix<double, 2, 3> by_nav = z.d_landmark * nav_R_world.transpose();
    rows.middleCols<3>(landmark.row) += by_nav;
    if (result.by_place.cols() > 0) {
      result.by_place.middleRows<2>(2 * i) =
          by_nav * known.by_place.middleRows<3>(landmark.row - n);
    }
    if (!x.nav_T_world) continue;
    rows.middleCols<3>(x.nav_row()) += by_nav * hat(nav_R_world * landmark.p_world);
    rows.middleCols<3>(x.nav_row() + 3) -= by_nav;
  }
  MatrixXd P(n + k, n + k);
  P << filter.covariance(), known.C.transpose(), known.C, known.P;
  result.S = dense::product(H, dense::product(P, H.transpose()));
  return result;
}

double returned_variance(double pixel_sigma) {
  return pixel_sigma * pixel_sigma + kOtherPoint * kOtherPoint;
}

// As the gate does, the test leaves out of the noise what many tracks share.
AcceptedMatches accepted_matches(const LoopInnovations& innovations,
                                 const std::vector<LoopCandidate>& candidates,
                                 const std::vector<ObservedLandmark>& observed,
                                 const Eigen::Vector3d& p_nav, const LoopNoise& noise,
                                 CompatibleMatches& compatible) {
  Eigen::MatrixXd S = innovations.S;
  S.diagonal().array() += returned_variance(noise.gate);
  const JointMatches joint =
      jointly_compatible(innovations.matches, innovations.r, S, kJointProbability);
  const auto found = static_cast<int>(joint.matches.size());
  const bool ambiguous = 2 * joint.runner_up > found;
  if (found < kLeastReturns || ambiguous) {
    compatible.clear();
    return {};
  }
  const std::vector<int> confirmed =
      confirmed_matches(joint.matches, innovations, candidates, observed, p_nav, compatible);
  if (static_cast<int>(confirmed.size()) < kLeastConfirmed) return {};
  const double variance = returned_variance(noise.update);
  S = innovations.S;
  S.diagonal().array() += variance;
  Informative best = most_informative(confirmed, S, variance, kLeastEach);
  if (best.nats < kLeastTogether) best.matches.clear();
  return {.matches = std::move(best.matches), .recognised = true};
}

}  // namespace chasles
