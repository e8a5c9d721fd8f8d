#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>

#include <chasles/frontend/coverage.hpp>

namespace chasles {
namespace {

constexpr int kPause = 5;                    // searches, after one without a corner
constexpr std::size_t kCornersPerCell = 24;  // candidates to consider

bool far_from_all(const std::vector<Eigen::Vector2d>& pixels, const Eigen::Vector2d& pixel,
                  double distance) {
  return std::none_of(pixels.begin(), pixels.end(), [&](const Eigen::Vector2d& other) {
    return (other - pixel).squaredNorm() < distance * distance;
  });
}

/// The part of a level that lies in a box of level 0.
PixelBox box_on(std::size_t level, const PixelBox& box) {
  const int up = (1 << level) - 1;
  return {.x0 = (box.x0 + up) >> level,
          .y0 = (box.y0 + up) >> level,
          .x1 = (box.x1 + up) >> level,
          .y1 = (box.y1 + up) >> level};
}

/// The corners of level 0 near the best ones of a coarser level, in this box. Where the measure has
/// a plateau, its maxima on both levels are at different places, so the coarse ones are refined.
std::vector<Corner> corners_near(const std::vector<Corner>& coarse, std::size_t level,
                                 const ImagePyramid& image, const PixelBox& box,
                                 const CoverageSettings& settings) {
  constexpr std::size_t kMost = 8;
  const int reach = 2 << level;  // two pixels of that level
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < std::min(coarse.size(), kMost); ++i) {
    const Eigen::Vector2d refined = refine_corner(image.levels[level], coarse[i].pixel);
    const Eigen::Vector2i pixel = (refined * (1 << level)).cast<int>();
    const PixelBox near{.x0 = std::max(box.x0, pixel.x() - reach),
                        .y0 = std::max(box.y0, pixel.y() - reach),
                        .x1 = std::min(box.x1, pixel.x() + reach + 1),
                        .y1 = std::min(box.y1, pixel.y() + reach + 1)};
    const std::vector<Corner> found =
        find_corners(image.levels[0], near, settings.measure, settings.min_gradient);
    if (!found.empty()) corners.push_back(found.front());
  }
  std::ranges::stable_sort(corners, std::greater{}, &Corner::score);
  return corners;
}

}  // namespace

bool masked(const GrayImage& mask, const Eigen::Vector2d& pixel) {
  if (mask.empty()) return false;
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, mask.width - 1);
  const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, mask.height - 1);
  return mask.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                     static_cast<std::size_t>(x)] == 0;
}

Coverage::Coverage(const CoverageSettings& settings, int width, int height)
    : settings_(settings), width_(width), height_(height) {
  const int border = static_cast<int>(std::ceil(settings.border));
  inside_ = {.x0 = border, .y0 = border, .x1 = width - border, .y1 = height - border};
  const auto edge = [](int i, int cells, int size) { return size * i / cells; };
  for (int r = 0; r < settings.rows; ++r) {
    for (int c = 0; c < settings.columns; ++c) {
      const PixelBox box{.x0 = std::max(border, edge(c, settings.columns, width)),
                         .y0 = std::max(border, edge(r, settings.rows, height)),
                         .x1 = std::min(width - border, edge(c + 1, settings.columns, width)),
                         .y1 = std::min(height - border, edge(r + 1, settings.rows, height))};
      cells_.push_back({.box = box});
    }
  }
}

std::size_t Coverage::cell_of(const Eigen::Vector2d& pixel) const {
  const auto index = [](double x, int size, int cells) {
    return std::clamp(static_cast<int>(std::floor(x * cells / size)), 0, cells - 1);
  };
  return static_cast<std::size_t>(index(pixel.y(), height_, settings_.rows) * settings_.columns +
                                  index(pixel.x(), width_, settings_.columns));
}

std::size_t Coverage::search_level(const ImagePyramid& image) const {
  std::size_t level = 0;
  while (level + 1 < image.levels.size() && (width_ * height_) >> (2 * level) > kMostSearched) {
    ++level;
  }
  return level;
}

std::vector<std::size_t> Coverage::cells_to_search(std::size_t tracks) const {
  const auto max_tracks = static_cast<std::size_t>(settings_.max_tracks);
  std::vector<std::size_t> order(cells_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (2 * tracks < max_tracks) return order;
  std::erase_if(order, [&](std::size_t i) { return cells_[i].pause > 0; });
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return cells_[a].tracks < cells_[b].tracks;
  });
  // Each searched cell gives one or two corners, so that no more cells than missing tracks are
  // needed.
  order.resize(std::min(
      {order.size(), static_cast<std::size_t>(settings_.cells_per_search), max_tracks - tracks}));
  return order;
}

std::vector<Eigen::Vector2d> Coverage::refill(const ImagePyramid& image, const GrayImage& mask,
                                              const std::vector<Eigen::Vector2d>& tracks) {
  std::vector<Eigen::Vector2d> added;
  if (tracks.size() >= static_cast<std::size_t>(settings_.max_tracks)) return added;
  for (Cell& cell : cells_) {
    cell.tracks = 0;
    cell.corners.clear();
    cell.pause = std::max(0, cell.pause - 1);
  }
  for (const Eigen::Vector2d& pixel : tracks) ++cells_[cell_of(pixel)].tracks;
  const std::size_t level = search_level(image);
  std::vector<Eigen::Vector2d> all = tracks;
  std::vector<std::size_t> open = cells_to_search(tracks.size());
  for (const std::size_t i : open) {
    Cell& cell = cells_[i];
    cell.corners = find_corners(image.levels[level], box_on(level, cell.box), settings_.measure,
                                settings_.min_gradient);
    std::erase_if(cell.corners, [&](const Corner& corner) {
      const Eigen::Vector2d pixel = corner.pixel * (1 << level);
      return masked(mask, pixel) || !far_from_all(all, pixel, settings_.min_distance);
    });
    if (level > 0) cell.corners = corners_near(cell.corners, level, image, inside_, settings_);
    if (cell.corners.size() > kCornersPerCell) cell.corners.resize(kCornersPerCell);
    if (cell.corners.empty()) cell.pause = kPause;
    std::reverse(cell.corners.begin(), cell.corners.end());  // best one last
  }
  // Among cells with equally many tracks, the one with the best corner.
  const auto emptier = [&](std::size_t i, std::size_t j) {
    const Cell &a = cells_[i], &b = cells_[j];
    if (a.tracks != b.tracks) return a.tracks < b.tracks;
    return a.corners.back().score > b.corners.back().score;
  };
  while (all.size() < static_cast<std::size_t>(settings_.max_tracks)) {
    std::erase_if(open, [&](std::size_t i) { return cells_[i].corners.empty(); });
    if (open.empty()) break;
    Cell& cell = cells_[*std::min_element(open.begin(), open.end(), emptier)];
    const Eigen::Vector2d found = cell.corners.back().pixel;
    cell.corners.pop_back();
    if (!far_from_all(all, found, settings_.min_distance)) continue;
    const Eigen::Vector2d corner = refine_corner(image.levels[0], found);
    if (masked(mask, corner) || !far_from_all(all, corner, settings_.min_distance)) continue;
    all.push_back(corner);
    added.push_back(corner);
    ++cell.tracks;
  }
  return added;
}

}  // namespace chasles
