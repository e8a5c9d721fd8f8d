#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/estimate/estimate.hpp>
#include <chasles/filter/ekf.hpp>

namespace chasles {

/// Correlates the whitened innovations of successive frames: those of a consistent filter are
/// white.
class InnovationCorrelation {
 public:
  /// Adds the products with the frame before to the estimate (Estimate::innovation_products).
  /// `observations`: of the measurements of the report, in the same order.
  void add(const std::vector<const PixelObservation*>& observations, const UpdateReport& report,
           Estimate& e);

 private:
  struct WhitenedPixel {
    LandmarkId landmark = 0;
    int camera = 0;
    Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
  };
  std::vector<WhitenedPixel> last_, now_;  ///< last_: sorted by landmark and camera
};

}  // namespace chasles
