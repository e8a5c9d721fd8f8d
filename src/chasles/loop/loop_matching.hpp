#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/loop/appearance.hpp>
#include <chasles/loop/joint_compatibility.hpp>

// The steps by which past landmarks are recognised by their appearance (docs/recognition.md).
namespace chasles {

/// So many past landmarks return together, or none.
inline constexpr int kLeastReturns = 5;

/// A landmark that has left the state and may return.
struct PastLandmark {
  int number = 0;                                   ///< in Ekf::past()
  Eigen::Vector3d p_nav = Eigen::Vector3d::Zero();  ///< when it left, or was last recalled [m]
  Appearance appearance = {};
  Time left{};  ///< when it left
};
using PastLandmarks = std::map<LandmarkId, PastLandmark>;

/// A landmark of the state, as it appears now.
struct ObservedLandmark {
  LandmarkId id = 0;
  int index = 0;  ///< into the state's landmarks
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  PatchView view = {};
};

/// A past landmark that appears like some of the observed ones.
struct LoopCandidate {
  LandmarkId id = 0;
  PastLandmark* past = nullptr;
  std::vector<std::pair<int, int>> like = {};  ///< Hamming distance, index of an ObservedLandmark
};

/// Landmarks in nav, in the order of the candidates, with their joint covariance P and C, that
/// with the errors of the state.
struct KnownLandmarks {
  std::vector<Landmark> landmarks;
  Eigen::MatrixXd C, P;
  Eigen::MatrixXd by_place;  ///< derivative by the unit errors of a proposed place, if any
};

/// The innovations of all similar pairs and their joint covariance without pixel noise.
struct LoopInnovations {
  std::vector<ProposedMatch> matches;  ///< of observed landmarks and candidates
  Eigen::VectorXd r;
  Eigen::MatrixXd S;
  Eigen::MatrixXd by_place;  ///< of r
};

/// Matches (track, landmark) that the last search found compatible, and from where first.
using CompatibleMatches = std::map<std::pair<LandmarkId, LandmarkId>, Eigen::Vector3d>;

/// The pose of a camera in nav, with the extrinsics of the state where it has any.
SE3 nav_T_camera(std::span<const Camera> cameras, const State& x, int index);

/// The landmarks of the state that camera 0 observes and whose depth is known, with their
/// descriptors in its image.
std::vector<ObservedLandmark> observed_landmarks(
    Describer& describer, std::span<const Camera> cameras, const Ekf& filter,
    const GrayImage& image, const std::vector<const PixelObservation*>& observations);

/// Past landmarks that may be in view and are similar to an observed one, in the order of their
/// numbers.
std::vector<LoopCandidate> similar_landmarks(std::span<const Camera> cameras, const State& x,
                                             PastLandmarks& past,
                                             const std::vector<ObservedLandmark>& observed);

/// All that is known now about past landmarks of the filter.
KnownLandmarks known_landmarks(const Ekf& filter, const std::vector<LoopCandidate>& candidates);

/// Compares the pixels of camera 0 with those that the known landmarks predict. The candidates'
/// p_nav become those of `known`.
LoopInnovations loop_innovations(const Camera& camera, const Ekf& filter,
                                 std::vector<LoopCandidate>& candidates,
                                 const KnownLandmarks& known,
                                 const std::vector<ObservedLandmark>& observed);

/// Standard deviations of a pixel [px].
struct LoopNoise {
  double gate = 1;    ///< without what many tracks share, as in the gate
  double update = 1;  ///< with it
};

/// Variance of the innovation of a landmark that returns, which is not quite the same point.
double returned_variance(double pixel_sigma);

struct AcceptedMatches {
  std::vector<int> matches;  ///< indices into LoopInnovations::matches
  /// Past landmarks were found, even if their return would have contained too little information.
  bool recognised = false;
};

/// The matches that are jointly compatible, have been so from another place too, and contain
/// information. Writes `compatible`. `p_nav`: of camera 0.
AcceptedMatches accepted_matches(const LoopInnovations& innovations,
                                 const std::vector<LoopCandidate>& candidates,
                                 const std::vector<ObservedLandmark>& observed,
                                 const Eigen::Vector3d& p_nav, const LoopNoise& noise,
                                 CompatibleMatches& compatible);

}  // namespace chasles
