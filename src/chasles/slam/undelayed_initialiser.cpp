#include <algorithm>

#include <chasles/slam/undelayed_initialiser.hpp>

namespace chasles {

std::optional<NewLandmark> UndelayedInitialiser::landmark(const SlamContext& x, LandmarkId id,
                                                          int camera_index,
                                                          const Eigen::Vector2d& pixel,
                                                          bool anchored) const {
  const Camera& camera = x.camera(camera_index);
  const InertialSlamSettings& s = x.settings;
  AssumedDepth depth{.mean = anchored ? s.inverse_depth : s.fixed_depth,
                     .sigma = anchored ? s.inverse_depth_sigma : s.fixed_depth_sigma};
  if (rule_) {
    const auto own = rule_({.state = x.state(),
                            .camera = camera,
                            .camera_index = camera_index,
                            .pixel = pixel,
                            .inverse = anchored});
    if (!own) return std::nullopt;
    depth = *own;
  }
  const auto begin = anchored ? initialise_anchored : initialise_at_depth;
  return begin(camera, x.track_noise().sigma, x.state(), id, pixel, depth.mean, depth.sigma,
               camera_index);
}

int UndelayedInitialiser::initialise(SlamContext& x,
                                     const std::vector<const PixelObservation*>& fresh) {
  const bool anchored = x.settings.landmarks == LandmarkForm::kInverseDepth;
  int room = x.settings.max_landmarks - static_cast<int>(x.state().landmarks.size());
  landmarks_.clear();
  for (const PixelObservation* o : fresh) {
    const bool started = std::any_of(landmarks_.begin(), landmarks_.end(),
                                     [&](const NewLandmark& l) { return l.id == o->landmark; });
    if (room <= 0 || started) continue;
    if (anchored && landmarks_.empty()) x.keep_pose(x.now);
    const auto made = landmark(x, o->landmark, o->camera, o->pixel, anchored);
    if (!made) continue;
    landmarks_.append() = *made;
    --room;
  }
  return x.add(landmarks_);
}

}  // namespace chasles
