#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// The outcomes of 256 comparisons of grey values in a patch (ORB: Rublee et al., ICCV 2011).
using Descriptor = std::array<std::uint64_t, 4>;

/// Number of comparisons with different outcomes: 0 to 256.
inline int hamming_distance(const Descriptor& a, const Descriptor& b) {
  int different = 0;
  for (std::size_t i = 0; i < a.size(); ++i) different += std::popcount(a[i] ^ b[i]);
  return different;
}

/// A patch of an image: its centre [px], and the steps in the image for one pixel of the patch to
/// the right (first column) and down.
struct ImagePatch {
  Eigen::Vector2d centre;
  Eigen::Matrix2d step;
};

/// Describes patches with OpenCV's ORB. The patch is what ORB sees: its orientation and scale are
/// those of the steps.
class Describer {
 public:
  Describer();
  ~Describer();
  /// It has no state: a copy is as new.
  Describer(const Describer&) : Describer() {}
  Describer& operator=(const Describer&) { return *this; }

  /// A descriptor for each patch; none if the patch is not inside the image.
  std::vector<std::optional<Descriptor>> describe(const GrayImage& image,
                                                  std::span<const ImagePatch> patches);

 private:
  struct Orb;
  std::unique_ptr<Orb> orb_;
};

}  // namespace chasles
