#include <algorithm>
#include <tuple>

#include <chasles/slam/innovation_correlation.hpp>

namespace chasles {

void InnovationCorrelation::add(const std::vector<const PixelObservation*>& observations,
                                const UpdateReport& report, Estimate& e) {
  const auto by_key = [](const WhitenedPixel& a, const WhitenedPixel& b) {
    return std::tie(a.landmark, a.camera) < std::tie(b.landmark, b.camera);
  };
  now_.clear();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!report.accepted[i]) continue;
    const Eigen::Vector2d w = report.whitened[i];
    const WhitenedPixel now{
        .landmark = observations[i]->landmark, .camera = observations[i]->camera, .innovation = w};
    now_.push_back(now);
    const auto before = std::lower_bound(last_.begin(), last_.end(), now, by_key);
    if (before == last_.end() || by_key(now, *before)) continue;
    e.innovation_products += w.dot(before->innovation);
    e.innovation_squares += (w.squaredNorm() + before->innovation.squaredNorm()) / 2;
  }
  std::sort(now_.begin(), now_.end(), by_key);
  last_.swap(now_);
}

}  // namespace chasles
