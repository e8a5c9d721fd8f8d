#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include <chasles/frontend/stereo_match.hpp>
#include <chasles/frontend/view_transfer.hpp>

namespace chasles {
namespace {

constexpr int kSearchLevel = 1;
constexpr double kSearchStep = 1.25;  // [px of that level]
constexpr float kSearchCorrelation = 0.5F;
constexpr double kClearlyBetter = 0.03;  // difference in correlation of two candidates that pass
constexpr int kMaxSearch = 400;          // steps

double focal(const Camera& camera) { return std::sqrt(focal_lengths_at_axis(camera).prod()); }

struct Candidate {
  double inverse_depth = 0;
  float correlation = -1;
};

struct Scored {
  StereoMatch match;
  double correlation = 0;
};

/// The two best local maxima of the correlation along the epipolar curve.
class BestTwo {
 public:
  void add(const Candidate& next) {
    if (middle_.correlation >= before_.correlation && middle_.correlation > next.correlation) {
      keep(middle_);
    }
    before_ = middle_;
    middle_ = next;
  }
  std::array<Candidate, 2> take() {
    add({});
    return best_;
  }

 private:
  void keep(const Candidate& peak) {
    if (peak.correlation > best_[0].correlation) {
      best_[1] = best_[0];
      best_[0] = peak;
    } else if (peak.correlation > best_[1].correlation) {
      best_[1] = peak;
    }
  }
  Candidate before_, middle_;
  std::array<Candidate, 2> best_;
};

// Of the patch of the query, around a pixel of the other camera.
Bow bow_at(const StereoViews& views, const Eigen::Vector2d& other_pixel,
           const StereoMatchSettings& settings) {
  if (!views.bends) return Bow::Zero();
  return transfer_bow(views.first, views.other, views.other_T_first.R, other_pixel,
                      settings.follow.window / 2);
}

std::array<Candidate, 2> search(const StereoViews& views, const StereoQuery& query,
                                const StereoMatchSettings& settings) {
  const std::size_t l = std::min({std::size_t{kSearchLevel}, views.first_image.levels.size() - 1,
                                  views.other_image.levels.size() - 1});
  const float scale = 1.0F / static_cast<float>(1 << l);
  BestTwo best;
  Patch patch;
  const std::optional<Transfer> far = transfer(query.ray, 0, views.other_T_first, views.other);
  PatchShape shape;
  if (far) {
    shape = {far->to_A_from.inverse().cast<float>(),
             bow_at(views, far->pixel, settings).cast<float>() / scale};
  }
  if (!shape.A.allFinite() || shape.A.cwiseAbs().maxCoeff() > 3 ||
      !make_patch(views.first_image.levels[l], query.pixel.cast<float>() * scale, shape,
                  settings.follow.window, 0.5F, patch)) {
    return best.take();
  }
  double inverse_depth = 0;
  for (int i = 0; i < kMaxSearch && inverse_depth <= 1 / settings.min_depth; ++i) {
    const auto at = transfer(query.ray, inverse_depth, views.other_T_first, views.other);
    if (!at) break;
    Candidate candidate{.inverse_depth = inverse_depth};
    if (in_image(views.other, at->pixel)) {
      candidate.correlation =
          correlation(patch, views.other_image.levels[l], at->pixel.cast<float>() * scale);
    }
    best.add(candidate);
    const double speed = std::max(at->d_inverse_depth.norm(), 1e-3);
    inverse_depth += kSearchStep / static_cast<double>(scale) / speed;
  }
  return best.take();
}

/// Follows the query's patch from its position at this depth, and checks the result.
std::optional<Scored> try_depth(const StereoViews& views, const StereoQuery& query,
                                double inverse_depth, int levels,
                                const StereoMatchSettings& settings) {
  const auto expected = transfer(query.ray, inverse_depth, views.other_T_first, views.other);
  if (!expected || !in_image(views.other, expected->pixel)) return std::nullopt;
  const Followed followed = follow(views.first_image, views.other_image,
                                   {.from = query.pixel,
                                    .to = expected->pixel,
                                    .to_A_from = expected->to_A_from,
                                    .levels = levels,
                                    .from_bow_to = bow_at(views, expected->pixel, settings)},
                                   settings.follow);
  if (followed.outcome != FollowOutcome::kFound) return std::nullopt;
  const auto match = triangulate_match(views, query.ray, followed.pixel,
                                       settings.epipolar_threshold / focal(views.other));
  if (!match || match->inverse_depth > 1 / settings.min_depth) return std::nullopt;
  return Scored{.match = *match, .correlation = followed.correlation};
}

}  // namespace

std::optional<StereoMatch> triangulate_match(const StereoViews& views, const WideRay& first,
                                             const Eigen::Vector2d& other_pixel, double threshold) {
  const std::optional<WideRay> other = wide_ray(views.other, other_pixel);
  if (!other) return std::nullopt;
  // other = lambda (r + rho t), in the plane of r (far) and t (near).
  const Eigen::Vector3d r = views.other_T_first.R * first.ray, &t = views.other_T_first.p;
  const Eigen::Vector3d f = other->ray.normalized();
  const Eigen::Vector3d normal = t.cross(r);
  const double size = normal.norm();
  if (!(size > 1e-6 * t.norm())) return std::nullopt;
  if (!(std::abs(f.dot(normal)) <= threshold * size)) return std::nullopt;
  // f x (r + rho t) = 0, least squares.
  const Eigen::Vector3d f_r = f.cross(r), f_t = f.cross(t);
  const double inverse_depth = -f_r.dot(f_t) / f_t.squaredNorm();
  if (!std::isfinite(inverse_depth)) return std::nullopt;
  // Angle by which the ray points beyond infinity, to be compared with the noise.
  const bool beyond = inverse_depth < 0 && r.normalized().cross(f).norm() > threshold;
  if (beyond || r.dot(f) + inverse_depth * t.dot(f) <= 0) return std::nullopt;
  return StereoMatch{.pixel = other_pixel, .inverse_depth = inverse_depth};
}

std::optional<StereoMatch> match_stereo(const StereoViews& views, const StereoQuery& query,
                                        const StereoMatchSettings& settings) {
  if (query.inverse_depth) {
    const auto near = try_depth(views, query, *query.inverse_depth, 2, settings);
    if (near) return near->match;
  }
  std::optional<Scored> best;
  for (const Candidate& candidate : search(views, query, settings)) {
    if (candidate.correlation < kSearchCorrelation) continue;
    const auto found = try_depth(views, query, candidate.inverse_depth, kSearchLevel + 1, settings);
    if (!found) continue;
    const bool same = best && (best->match.pixel - found->match.pixel).norm() < 1;
    if (best && !same && std::abs(best->correlation - found->correlation) < kClearlyBetter) {
      return std::nullopt;
    }
    if (!best || found->correlation > best->correlation) best = found;
  }
  if (!best) return std::nullopt;
  return best->match;
}

}  // namespace chasles
