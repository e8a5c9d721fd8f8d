#pragma once

#include <string>
#include <vector>

#include <chasles/camera/image_frame.hpp>
#include <chasles/target/tag_reader.hpp>
#include <chasles/target/target.hpp>

namespace chasles {

/// What a detector found in an image.
struct TargetDetection {
  TargetView view;  ///< time and camera are those of the caller
  /// Standard deviation of each pixel of the view, in both directions, by the grey values [px].
  std::vector<double> sigmas;
  int tags = 0;           ///< that were read
  int saddle_points = 0;  ///< in the whole image: corners of the board and others
  double blur = 0;        ///< standard deviation of the edges' blur, median over the corners [px]
  double spacing = 0;     ///< the shorter distance of neighbouring corners, median [px]
  /// Why corners are missing, e.g. "12 of 144 corners: the edges are blurred over 3.1 px"; empty
  /// where the view has all of them.
  std::string lack;
};

/// Finds the corners of a target in images of any lens. A view holds no corner twice, and only
/// corners whose place on the board is certain: by tags that were read and squares that connect
/// them, or by the whole lattice of a checkerboard, of which single corners may be
/// too uncertain. A board with tags may be partly visible.
///
/// Corners are saddle points between straight edges, which form quads that share edges; the tags in
/// the quads say where they are on the board (the position in the image by refined_corner()). The
/// same image gives the same corners. Several threads may use a detector at a time.
class TargetDetector {
 public:
  /// Throws UsageError as validate().
  explicit TargetDetector(const Target& target);

  TargetDetection detect(const GrayImage& image) const;

  const Target& target() const { return target_; }

 private:
  Target target_;
  std::vector<Eigen::Vector3d> corners_;
  TagReader reader_;
};

}  // namespace chasles
