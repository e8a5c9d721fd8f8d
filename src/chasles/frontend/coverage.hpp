#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/image_frame.hpp>
#include <chasles/frontend/corners.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {

/// Settings for the distribution of tracks over an image.
struct CoverageSettings {
  CornerMeasure measure = CornerMeasure::kHarris;
  int max_tracks = 150;
  int columns = 10, rows = 6;  ///< of the grid of cells
  int cells_per_search = 15;   ///< unless half of the tracks are lost
  double min_distance = 15;    ///< of a new corner to every track and corner [px]
  double border = 8;           ///< margin without corners [px]
  double min_gradient = 3;     ///< of a corner in its weakest direction [grey levels/px]
};

/// Finds new corners where tracks are fewest. Its only memory is of cells without corners, which it
/// skips for some searches.
class Coverage {
 public:
  static constexpr int kMostSearched = 600'000;

  Coverage(const CoverageSettings& settings, int width, int height);

  /// New corners for an image with the pixels `tracks`, so that the total is at most max_tracks.
  /// Repeatedly, the cell with the fewest tracks contributes its best corner. No corners where
  /// `mask` (empty, or as large as the image) is 0. In large images, corners are searched on the
  /// finest level of the pyramid with at most kMostSearched pixels, or its coarsest one, and on
  /// level 0 only near the best of them.
  std::vector<Eigen::Vector2d> refill(const ImagePyramid& image, const GrayImage& mask,
                                      const std::vector<Eigen::Vector2d>& tracks);

 private:
  struct Cell {
    PixelBox box;
    int tracks = 0;
    int pause = 0;  // searches for which it is still skipped
    std::vector<Corner> corners = {};
  };

  std::size_t search_level(const ImagePyramid& image) const;
  std::vector<std::size_t> cells_to_search(std::size_t tracks) const;
  std::size_t cell_of(const Eigen::Vector2d& pixel) const;

  CoverageSettings settings_;
  int width_ = 0, height_ = 0;
  PixelBox inside_;  // without the border
  std::vector<Cell> cells_;
};

/// Whether the mask (empty: none) excludes a pixel.
bool masked(const GrayImage& mask, const Eigen::Vector2d& pixel);

}  // namespace chasles
