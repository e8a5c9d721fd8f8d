#include <algorithm>
#include <map>
#include <optional>

#include <fmt/format.h>

#include <chasles/target/board_placement.hpp>
#include <chasles/target/corner_lattice.hpp>
#include <chasles/target/corner_neighbours.hpp>
#include <chasles/target/refine_corner.hpp>
#include <chasles/target/saddle_points.hpp>
#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target_detector.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr double kLargestRadius = 5;  // [px] around a corner that is refined
constexpr double kSmallestRadius = 2;

// What is on an image before its corners are on the board.
struct Pieces {
  GreyPlane image, smooth;
  std::vector<SaddlePoint> points;
  std::vector<Quad> quads;
  std::vector<CornerLattice> lattices;
};

Pieces pieces_of(const GrayImage& image) {
  Pieces result;
  result.image = grey_plane(image);
  if (image.width < 16 || image.height < 16) return result;
  result.smooth = smoothed(result.image);
  result.points = find_saddle_points(result.image);
  result.quads = find_quads(result.smooth, result.points);
  result.lattices = connect_quads(result.quads);
  return result;
}

TagPlacement place(const Target& target, const TagReader& reader, const Pieces& pieces,
                   const CornerLattice& lattice) {
  if (target.kind == TargetKind::checkerboard) {
    return {place_checkerboard(target, pieces.points, pieces.quads, lattice), 0};
  }
  return place_by_tags(target, reader, pieces.image, pieces.points, pieces.quads, lattice);
}

// Parts of the board that a hand separates add up. The same corners again are those of another
// board, or of quads that contradict the first ones.
void add_corners(const Target& target, const Pieces& pieces, const CornerLattice& lattice,
                 const BoardPlacement& placement, FoundCorners& corners) {
  const CornerGrid grid = corner_grid(target);
  FoundCorners added;
  for (const auto& [point, at] : lattice.positions) {
    const Vector2i place = placement.on_board(at);
    if (!is_in(grid, place)) continue;
    const std::pair key(place.x(), place.y());
    if (corners.contains(key)) return;
    added.emplace(key, pieces.points[static_cast<std::size_t>(point)]);
  }
  corners.merge(added);
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Corners of the grid, with the precise pixels, into the view by their ids.
void fill_view(const Target& target, const GreyPlane& image, const FoundCorners& corners,
               TargetDetection& result) {
  std::map<int, RefinedCorner> refined;
  std::vector<double> blurs;
  for (const auto& [place, free] : free_radii(target, corners)) {
    const SaddlePoint& point = corners.at(place);
    const double radius = std::clamp(free, kSmallestRadius, kLargestRadius);
    const auto corner = refined_corner(image, point, radius);
    if (!corner) continue;
    refined.emplace(corner_id(target, {place.first, place.second}), *corner);
    blurs.push_back(corner->blur);
  }
  for (const auto& [id, corner] : refined) {
    result.view.ids.push_back(id);
    result.view.pixels.push_back(corner.pixel);
    result.sigmas.push_back(corner.sigma);
  }
  result.blur = median_of(blurs);
  result.spacing = median_of(spacings(corners));
}

bool is_at_border(const TargetView& view, const GrayImage& image, double border) {
  return std::ranges::any_of(view.pixels, [&](const Vector2d& p) {
    return std::min({p.x(), p.y(), image.width - 1 - p.x(), image.height - 1 - p.y()}) < border;
  });
}

// Why lattices have no place on the board.
struct Misfits {
  int contradicting = 0;  // tags
  bool beyond = false;    // corners outside of the board
};

std::string why_none(const Target& target, const Pieces& pieces, const Misfits& misfits) {
  if (pieces.points.empty()) {
    return "no crossing edges: the image is dark, blurred or shows no board";
  }
  if (pieces.quads.empty()) {
    return fmt::format(
        "{} crossing edges, but no squares between them: the board is small, "
        "blurred, covered or not in the image",
        pieces.points.size());
  }
  if (target.kind == TargetKind::checkerboard) {
    return fmt::format(
        "the largest group of squares has {} corners, expected all {} of {} x {}: a checkerboard "
        "must be in the image wholly, and have this size",
        pieces.lattices.front().positions.size(), target.columns * target.rows, target.columns,
        target.rows);
  }
  if (misfits.beyond || misfits.contradicting > 1) {
    return fmt::format(
        "{}: the board is not {} x {}{}, as its file states",
        misfits.beyond ? "squares go on beyond the board" : "tags contradict each other",
        target.columns, target.rows,
        target.kind == TargetKind::charuco
            ? fmt::format(" with legacy_pattern {}", target.legacy_pattern)
            : "");
  }
  return fmt::format(
      "{} squares, but no tag of this board could be read with certainty: other "
      "tags, or tags too small, blurred or covered",
      pieces.quads.size());
}

std::string why_few(const GrayImage& image, std::size_t all, const TargetDetection& detection) {
  const std::size_t count = detection.view.ids.size();
  if (count == all) return "";
  std::string text = fmt::format("{} of {} corners: ", count, all);
  if (detection.blur > 0.2 * detection.spacing) {
    return text + fmt::format("the edges are blurred over {:.1f} px, with corners {:.1f} px apart",
                              2 * detection.blur, detection.spacing);
  }
  if (detection.spacing < 6) {
    return text +
           fmt::format("the board is small, with corners {:.1f} px apart", detection.spacing);
  }
  if (is_at_border(detection.view, image, 1.5 * detection.spacing)) {
    return text + "the board leaves the image";
  }
  return text + "parts are covered, noisy, or have little contrast";
}

}  // namespace

TargetDetector::TargetDetector(const Target& target)
    : target_((validate(target), target)), corners_(target.corners()), reader_(target) {}

TargetDetection TargetDetector::detect(const GrayImage& image) const {
  const Pieces pieces = pieces_of(image);
  TargetDetection result;
  result.saddle_points = static_cast<int>(pieces.points.size());
  Misfits misfits;
  FoundCorners corners;
  for (const CornerLattice& lattice : pieces.lattices) {
    const TagPlacement placed = place(target_, reader_, pieces, lattice);
    if (!placed.placement) {
      misfits.contradicting = std::max(misfits.contradicting, placed.read);
      continue;
    }
    if (reaches_beyond(target_, *placed.placement, lattice)) {
      misfits.beyond = true;
      continue;
    }
    result.tags += placed.placement->votes;
    add_corners(target_, pieces, lattice, *placed.placement, corners);
  }
  remove_misplaced(target_, corners);
  add_missing(target_, pieces.smooth, pieces.points, corners);
  fill_view(target_, pieces.image, corners, result);
  // Which corner is which is certain where the lattice is whole; of some the place may not be.
  const bool is_whole =
      corners.size() == corners_.size() && 2 * result.view.ids.size() >= corners_.size();
  if (target_.kind == TargetKind::checkerboard && !is_whole) {
    result.view = {};
    result.sigmas = {};
  }
  result.lack = result.view.ids.empty() ? why_none(target_, pieces, misfits)
                                        : why_few(image, corners_.size(), result);
  return result;
}

}  // namespace chasles
