#include <algorithm>
#include <chrono>
#include <utility>

#include <chasles/filter/calibration.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/slam/inertial_slam.hpp>

// Past landmarks are recognised by appearance (docs/recognition.md).
namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Every return composes the past, so landmarks are looked for now and then, several at a time.
// A proposed place in a map waits for its confirmation alone.
constexpr Time kInterval = std::chrono::milliseconds(300);
constexpr Time kWhileProposed = std::chrono::milliseconds(100);
constexpr double kKnownDepth = 0.2;  // relative sigma, for the size of a patch
// Landmarks that are compared at a time, and observations for each of them.
constexpr std::size_t kMostLandmarks = 25, kMostEach = 3;
// How far from its expected place a landmark may look similar, as a part of the image's width. What
// is possible is decided with its covariance, later.
constexpr double kReach = 0.3;
constexpr double kProbability = 0.95;
constexpr int kLeastMatches = 5, kLeastConfirmed = 4;
constexpr double kLeastParallax = 0.02;  // [rad]
// Landmarks return where they determine so much [nat]: each of them given the others, and together.
constexpr double kLeastEach = 0.2, kLeastTogether = 3;

constexpr double square(double x) { return x * x; }

}  // namespace

SE3 InertialSlam::nav_T_camera(int index) const {
  const State& x = filter_.state();
  const Camera camera = as_estimated(cameras_[static_cast<std::size_t>(index)], x, index);
  const SE3 world_T_cam = x.world_T_imu * camera.cam_T_imu.inverse();
  return x.nav_T_world ? *x.nav_T_world * world_T_cam : world_T_cam;
}

// Whether landmarks have returned because camera 0 sees something that looks like them.
bool InertialSlam::recognise(const FeatureFrame& frame,
                             const std::vector<const PixelObservation*>& observations) {
  const bool has_image = frame.images && !frame.images->images.empty();
  const Time interval = prior_ && prior_->place ? kWhileProposed : kInterval;
  if (!has_image || (searched_ && now_ - *searched_ < interval)) return false;
  searched_ = now_;
  const std::vector<SeenLandmark> seen = see_landmarks(frame.images->images.front(), observations);
  const bool found =
      (prior_ && find_place_in_map(seen)) || recognise_among(inactive_, compatible_, seen);
  for (const SeenLandmark& s : seen) {
    if (!known_as_.contains(s.id)) appearances_[s.id].add(s.view);
  }
  return found;
}

// Whether some of these past landmarks have returned.
bool InertialSlam::recognise_among(InactiveLandmarks& past, CompatibleMatches& compatible,
                                   const std::vector<SeenLandmark>& seen) {
  std::vector<Candidate> candidates = similar_landmarks(past, seen);
  if (candidates.size() < kLeastMatches) {
    compatible.clear();
    return false;
  }
  const bool placed = &past == &inactive_;
  const Comparison comparison =
      compare(candidates, placed ? known_landmarks(candidates) : known_points(candidates), seen);
  const std::vector<int> accepted = accepted_matches(comparison, candidates, seen, compatible);
  if (accepted.empty()) return false;
  if (!placed && !finds_place_again(comparison, accepted, candidates, seen)) {
    compatible.clear();
    return false;
  }
  without_ = without(comparison, accepted, candidates);
  if (!placed) {
    refine_place(comparison, accepted, candidates, seen);
    place_map();
  }
  close_loop(comparison, accepted, candidates, seen);
  return true;
}

// The landmarks of the state as they look now, with known depth.
std::vector<InertialSlam::SeenLandmark> InertialSlam::see_landmarks(
    const GrayImage& image, const std::vector<const PixelObservation*>& observations) {
  const State& x = filter_.state();
  const SE3 nav_T_cam = nav_T_camera(0);
  const SE3 cam_T_world =
      x.nav_T_world ? nav_T_cam.inverse() * *x.nav_T_world : nav_T_cam.inverse();
  std::vector<SeenLandmark> seen;
  std::vector<ImagePatch> patches;
  number_landmarks();
  for (const PixelObservation* o : observations) {
    const auto number = o->camera == 0 ? number_of(o->landmark) : std::nullopt;
    if (!number) continue;
    const Landmark& landmark = x.landmarks[static_cast<std::size_t>(*number)];
    const bool known =
        landmark.has_place() && (!landmark.anchor || filter_.inverse_depth_sigma(landmark) <
                                                         kKnownDepth * landmark.inverse_depth.z());
    if (!known) continue;
    auto found = view_patches(cameras_.front(), nav_T_cam.R, cam_T_world * x.p_world(landmark));
    if (!found) continue;
    for (ImagePatch& patch : found->patches) patch.centre = o->pixel;
    patches.insert(patches.end(), found->patches.begin(), found->patches.end());
    seen.push_back({.id = o->landmark, .index = *number, .pixel = o->pixel, .view = found->view});
  }
  const auto descriptors = describer_.describe(image, patches);
  std::vector<SeenLandmark> described;
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

// Past landmarks that may be in view and look like a landmark of the state, in the order of their
// numbers.
std::vector<InertialSlam::Candidate> InertialSlam::similar_landmarks(
    InactiveLandmarks& past, const std::vector<SeenLandmark>& seen) {
  const SE3 nav_T_cam = nav_T_camera(0), cam_T_nav = nav_T_cam.inverse();
  const Camera& camera = cameras_.front();
  const double reach = kReach * camera.width;
  std::vector<Candidate> candidates;
  for (auto& [id, inactive] : past) {
    const auto expected = view_patches(camera, nav_T_cam.R, cam_T_nav * inactive.p_nav);
    if (!expected || !in_image(camera, expected->patches.front().centre, -reach) ||
        !inactive.appearance.may_match(expected->view)) {
      continue;
    }
    Candidate candidate{.id = id, .inactive = &inactive};
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if ((seen[i].pixel - expected->patches.front().centre).norm() > reach) continue;
      const auto distance = inactive.appearance.distance(seen[i].view);
      if (distance && *distance <= kSimilarBits) {
        candidate.like.emplace_back(*distance, static_cast<int>(i));
      }
    }
    if (candidate.like.empty()) continue;
    std::ranges::sort(candidate.like);
    if (candidate.like.size() > kMostEach) candidate.like.resize(kMostEach);
    candidates.push_back(std::move(candidate));
  }
  std::ranges::stable_sort(candidates, {}, [](const Candidate& c) { return c.like.front().first; });
  if (candidates.size() > kMostLandmarks) candidates.resize(kMostLandmarks);
  std::ranges::sort(candidates, {}, [](const Candidate& c) { return c.inactive->number; });
  return candidates;
}

// All that is known now about past landmarks.
InertialSlam::KnownLandmarks InertialSlam::known_landmarks(
    const std::vector<Candidate>& candidates) const {
  std::vector<int> numbers;
  for (const Candidate& c : candidates) numbers.push_back(c.inactive->number);
  Carried past = filter_.past().recall(numbers);
  KnownLandmarks known{
      .landmarks = {}, .C = std::move(past.C), .P = std::move(past.P), .by_place = {}};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    known.landmarks.push_back(filter_.past().landmark(numbers[i]));
    known.landmarks.back().p_world += past.correction.segment<3>(3 * static_cast<Index>(i));
  }
  return known;
}

// The innovations of all similar pairs and their joint covariance without pixel noise.
InertialSlam::Comparison InertialSlam::compare(std::vector<Candidate>& candidates,
                                               const KnownLandmarks& known,
                                               const std::vector<SeenLandmark>& seen) const {
  const Index n = filter_.covariance().rows(), k = known.P.rows();
  // A state in which the past landmarks follow the filter's own errors.
  State x = filter_.state();
  x.landmarks.clear();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Index at = 3 * static_cast<Index>(i);
    Landmark landmark = known.landmarks[i];
    landmark.row = static_cast<int>(n + at);
    candidates[i].inactive->p_nav = landmark.p_world;
    if (x.nav_T_world) landmark.p_world = x.nav_T_world->inverse() * landmark.p_world;
    x.landmarks.push_back(landmark);
  }
  Comparison result;
  std::vector<Measurement> measurements;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (const auto& [distance, index] : candidates[i].like) {
      const SeenLandmark& s = seen[static_cast<std::size_t>(index)];
      const auto z = measure_pixel(cameras_.front(), 1, x, static_cast<int>(i), s.pixel);
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
  P << filter_.covariance(), known.C.transpose(), known.C, known.P;
  result.S = dense::product(H, dense::product(P, H.transpose()));
  return result;
}

// Those that are jointly compatible, have been so from another place too, and determine something.
// As the gate does, the test leaves out of the noise what many tracks share.
std::vector<int> InertialSlam::accepted_matches(const Comparison& comparison,
                                                const std::vector<Candidate>& candidates,
                                                const std::vector<SeenLandmark>& seen,
                                                CompatibleMatches& compatible) {
  MatrixXd S = comparison.S;
  S.diagonal().array() += square(pixel_sigma_) + square(kOtherPoint);
  const JointMatches joint = jointly_compatible(comparison.matches, comparison.r, S, kProbability);
  const auto found = static_cast<int>(joint.matches.size());
  const bool ambiguous = 2 * joint.runner_up > found;
  if (found < kLeastMatches || ambiguous) {
    compatible.clear();
    return {};
  }
  const std::vector<int> confirmed =
      confirmed_matches(joint.matches, comparison, candidates, seen, compatible);
  if (static_cast<int>(confirmed.size()) < kLeastConfirmed) return {};
  recognised_.push_back(clock(now_));
  const double noise = square(track_noise().sigma) + square(kOtherPoint);
  S = comparison.S;
  S.diagonal().array() += noise;
  const Informative best = most_informative(confirmed, S, noise, kLeastEach);
  return best.nats < kLeastTogether ? std::vector<int>{} : best.matches;
}

// A wrong match is compatible with the right ones by chance, and from another place no longer.
std::vector<int> InertialSlam::confirmed_matches(const std::vector<int>& joint,
                                                 const Comparison& comparison,
                                                 const std::vector<Candidate>& candidates,
                                                 const std::vector<SeenLandmark>& seen,
                                                 CompatibleMatches& compatible) const {
  const Vector3d p_nav = nav_T_camera(0).p;
  CompatibleMatches now;
  std::vector<int> confirmed;
  for (const int i : joint) {
    const ProposedMatch& match = comparison.matches[static_cast<std::size_t>(i)];
    const Candidate& candidate = candidates[static_cast<std::size_t>(match.landmark)];
    const std::pair key(seen[static_cast<std::size_t>(match.observation)].id, candidate.id);
    const auto before = compatible.find(key);
    const Vector3d first = before == compatible.end() ? p_nav : before->second;
    const double parallax = (p_nav - first).norm() / (candidate.inactive->p_nav - p_nav).norm();
    if (parallax >= kLeastParallax) confirmed.push_back(i);
    now.emplace(key, first);
  }
  compatible = std::move(now);
  return confirmed;
}

// The landmark of the state is the past one: it gives way, and its track continues as the past one.
void InertialSlam::close_loop(const Comparison& comparison, const std::vector<int>& accepted,
                              std::vector<Candidate>& candidates,
                              const std::vector<SeenLandmark>& seen) {
  std::vector<int> numbers, gone;
  returned_.clear();
  for (const int i : accepted) {
    const ProposedMatch& match = comparison.matches[static_cast<std::size_t>(i)];
    const SeenLandmark& s = seen[static_cast<std::size_t>(match.observation)];
    Candidate& old = candidates[static_cast<std::size_t>(match.landmark)];
    for (auto& [track, landmark] : known_as_) {
      if (landmark == s.id) landmark = old.id;
    }
    known_as_[s.id] = old.id;
    returned_.push_back(old.id);
    numbers.push_back(old.inactive->number);
    gone.push_back(s.index);
    appearances_.erase(s.id);
    Appearance& appearance = appearances_[old.id];
    appearance = std::move(old.inactive->appearance);
    appearance.add(s.view);
    inactive_.erase(old.id);
  }
  std::ranges::sort(gone);
  for (auto i = gone.rbegin(); i != gone.rend(); ++i) last_.erase(last_.begin() + *i);
  filter_.remove(gone);
  revive(std::move(numbers));
  const State& x = filter_.state();
  const std::size_t first = x.landmarks.size() - accepted.size();
  for (std::size_t i = first; i < x.landmarks.size(); ++i) {
    filter_.add_noise(static_cast<int>(i),
                      drift_noise(cameras_.front(), x, x.landmarks[i], square(kOtherPoint), 0));
  }
  closures_.push_back({.time = clock(now_),
                       .landmarks = static_cast<int>(accepted.size()),
                       .square = joint_square(accepted, comparison.r, comparison.S,
                                              square(pixel_sigma_) + square(kOtherPoint)),
                       .dof = 2 * static_cast<int>(accepted.size())});
}

// A copy in which these landmarks do not return, nor later: the place of a map is rejected.
std::shared_ptr<InertialSlam> InertialSlam::without(
    const Comparison& comparison, const std::vector<int>& accepted,
    const std::vector<Candidate>& candidates) const {
  auto copy = std::make_shared<InertialSlam>(*this);
  if (prior_) {
    copy->prior_ = Prior{.map = prior_->map};
    ++copy->place_counts_.rejected;
    return copy;
  }
  std::vector<int> numbers;
  for (const int i : accepted) {
    const ProposedMatch& match = comparison.matches[static_cast<std::size_t>(i)];
    const Candidate& old = candidates[static_cast<std::size_t>(match.landmark)];
    numbers.push_back(old.inactive->number);
    copy->inactive_.erase(old.id);
  }
  copy->filter_.marginalise(numbers);
  copy->compatible_.clear();
  return copy;
}

void InertialSlam::note_change(const SE3& before, const SE3& after) {
  closures_.back().moved = (after.p - before.p).norm();
  closures_.back().turned = so3::log(after.R * before.R.transpose()).norm();
}

}  // namespace chasles
