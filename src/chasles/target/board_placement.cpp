#include <algorithm>
#include <array>
#include <tuple>

#include <chasles/target/board_placement.hpp>
#include <chasles/target/tag_layout.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

// The y axis of the image goes down, that of the board up.
Vector2i turned_up(const Vector2i& lattice, int turn) {
  Vector2i at(lattice.x(), -lattice.y());
  for (int k = 0; k < turn; ++k) at = Vector2i(-at.y(), at.x());
  return at;
}

std::array<Vector2d, 4> pixels_of(const Quad& quad, const std::vector<SaddlePoint>& points) {
  std::array<Vector2d, 4> result;
  for (std::size_t k = 0; k < 4; ++k) {
    result[k] = points[static_cast<std::size_t>(quad.corners[k])].pixel;
  }
  return result;
}

// Where the lattice lies if the quad shows that tag.
BoardPlacement placement_of(const ReadTag& read, const PrintedTag& tag, const Quad& quad,
                            const CornerLattice& lattice) {
  const auto corner = [&](int k) {  // clockwise from the upper left
    return lattice.positions.at(quad.corners[static_cast<std::size_t>(read.upper_left + k) % 4]);
  };
  BoardPlacement result;
  while (turned_up(corner(1) - corner(0), result.turn) != Vector2i(1, 0)) ++result.turn;
  result.offset = tag.grid - turned_up(corner(3), result.turn);
  return result;
}

struct Votes {
  int count = 0, least_wrong = 0;
};
using VotesOfPlacements = std::map<std::tuple<int, int, int>, Votes>;

// The placement of the most tags, unless more than a few contradict it: on a board of another width
// than stated each row has a place of its own.
std::optional<BoardPlacement> winner(const VotesOfPlacements& votes, const TagReader& reader) {
  constexpr int kFew = 5;  // times fewer
  std::optional<BoardPlacement> best;
  int all = 0, least_wrong = 0;
  for (const auto& [key, vote] : votes) {
    all += vote.count;
    if (best && vote.count <= best->votes) continue;
    best = {std::get<0>(key), {std::get<1>(key), std::get<2>(key)}, vote.count};
    least_wrong = vote.least_wrong;
  }
  if (!best || kFew * (all - best->votes) > best->votes) return std::nullopt;
  if (best->votes == 1 && !reader.proves(least_wrong)) return std::nullopt;
  return best;
}

// The lower left corner of the quad's square on the board.
Vector2i square_of(const Quad& quad, const CornerLattice& lattice,
                   const BoardPlacement& placement) {
  Vector2i least = placement.on_board(lattice.positions.at(quad.corners[0]));
  for (const int corner : quad.corners) {
    least = least.cwiseMin(placement.on_board(lattice.positions.at(corner)));
  }
  return least;
}

// How far the board's x axis points to the right in the image [px], summed over edges.
double rightward(const std::vector<SaddlePoint>& points, const CornerLattice& lattice,
                 const BoardPlacement& placement) {
  double sum = 0;
  Vector2d middle = Vector2d::Zero(), middle_pixel = Vector2d::Zero();
  const auto count = static_cast<double>(lattice.positions.size());
  for (const auto& [point, at] : lattice.positions) {
    middle += placement.on_board(at).cast<double>() / count;
    middle_pixel += points[static_cast<std::size_t>(point)].pixel / count;
  }
  for (const auto& [point, at] : lattice.positions) {
    sum += (placement.on_board(at).x() - middle.x()) *
           (points[static_cast<std::size_t>(point)].pixel.x() - middle_pixel.x());
  }
  return sum;
}

}  // namespace

Vector2i BoardPlacement::on_board(const Vector2i& lattice) const {
  return turned_up(lattice, turn) + offset;
}

bool reaches_beyond(const Target& target, const BoardPlacement& placement,
                    const CornerLattice& lattice) {
  constexpr double kFew = 0.04;  // of the corners: what is behind the board may from like a square
  const CornerGrid grid = corner_grid(target);
  int outside = 0;
  for (const auto& [point, at] : lattice.positions) {
    if (!is_in(grid, placement.on_board(at))) ++outside;
  }
  return outside >= 2 && outside > kFew * static_cast<double>(lattice.positions.size());
}

TagPlacement place_by_tags(const Target& target, const TagReader& reader, const GreyPlane& image,
                           const std::vector<SaddlePoint>& points, const std::vector<Quad>& quads,
                           const CornerLattice& lattice) {
  const std::vector<PrintedTag> tags = printed_tags(target);
  VotesOfPlacements votes;
  int count = 0;
  for (const int index : lattice.quads) {
    const Quad& quad = quads[static_cast<std::size_t>(index)];
    if (quad.dark != (target.kind == TargetKind::april_grid)) continue;
    const auto read = reader.read(image, pixels_of(quad, points));
    if (!read) continue;
    const BoardPlacement p =
        placement_of(*read, tags[static_cast<std::size_t>(read->tag)], quad, lattice);
    Votes& vote = votes[{p.turn, p.offset.x(), p.offset.y()}];
    vote.least_wrong =
        vote.count == 0 ? read->wrong_bits : std::min(vote.least_wrong, read->wrong_bits);
    ++vote.count;
    ++count;
  }
  return {winner(votes, reader), count};
}

std::optional<BoardPlacement> place_checkerboard(const Target& target,
                                                 const std::vector<SaddlePoint>& points,
                                                 const std::vector<Quad>& quads,
                                                 const CornerLattice& lattice) {
  const CornerGrid grid = corner_grid(target);
  if (3 * lattice.positions.size() < 2 * static_cast<std::size_t>(grid.columns) * grid.rows) {
    return std::nullopt;
  }
  std::optional<BoardPlacement> best;
  double most_right = 0;
  for (int turn = 0; turn < 4; ++turn) {
    BoardPlacement placement{.turn = turn, .offset = Vector2i::Zero(), .votes = 0};
    Vector2i low = Vector2i::Constant(1 << 20), high = -low;
    for (const auto& [point, at] : lattice.positions) {
      low = low.cwiseMin(placement.on_board(at));
      high = high.cwiseMax(placement.on_board(at));
    }
    placement.offset = -low;
    if (high - low != Vector2i(grid.columns - 1, grid.rows - 1)) continue;
    const Quad& quad = quads[static_cast<std::size_t>(lattice.quads.front())];
    const Vector2i square = square_of(quad, lattice, placement);
    if (!target.is_symmetric() && is_dark_to_upper_right(target, square) != quad.dark) continue;
    const double right = rightward(points, lattice, placement);
    if (best && right <= most_right) continue;
    best = placement;
    most_right = right;
  }
  return best;
}

}  // namespace chasles
