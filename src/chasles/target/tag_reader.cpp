#include <algorithm>
#include <bit>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <chasles/target/marker_dictionary.hpp>
#include <chasles/target/tag_reader.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLeastStep = 10;      // grey values between black and white
constexpr double kWrongBorder = 0.08;  // of the cells of the border
constexpr double kWrongBits = 0.12;    // of the bits, where the codes differ enough

using Corners = std::array<Vector2d, 4>;

// Maps (0, 0), (1, 0), (1, 1), (0, 1) to the corners (Heckbert, "Fundamentals of texture mapping
// and image warping", 1989, section 2.2.3).
Matrix3d square_to(const Corners& c) {
  const Vector2d d1 = c[1] - c[2], d2 = c[3] - c[2], s = c[0] - c[1] + c[2] - c[3];
  const double det = d1.x() * d2.y() - d2.x() * d1.y();
  const double g = (s.x() * d2.y() - d2.x() * s.y()) / det;
  const double h = (d1.x() * s.y() - s.x() * d1.y()) / det;
  Matrix3d H;
  H.col(0) << c[1] - c[0] + g * c[1], g;
  H.col(1) << c[3] - c[0] + h * c[3], h;
  H.col(2) << c[0], 1;
  return H;
}

// The grey values of a tag's cells, row by row, and of the white around it.
struct TagSamples {
  std::vector<double> cells;
  std::vector<std::pair<Vector2d, double>> black, white;  // where, in cells, and how bright
};

// A surface a + b x + c y through grey values.
Vector3d plane_of(const std::vector<std::pair<Vector2d, double>>& samples) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const auto& [at, value] : samples) {
    const Vector3d row(1, at.x(), at.y());
    normal += row * row.transpose();
    right += row * value;
  }
  return normal.ldlt().solve(right);
}

class Sampler {
 public:
  // `H` maps cells to pixels.
  Sampler(const GreyPlane& image, const Matrix3d& H) : image_(image), H_(H) {}

  std::optional<double> at(const Vector2d& cell) const {
    const Vector3d p = H_ * cell.homogeneous();
    if (p.z() <= 1e-6) return std::nullopt;
    const Vector2d pixel = p.hnormalized();
    if (!image_.contains(pixel, 0)) return std::nullopt;
    return static_cast<double>(image_.at(pixel));
  }

 private:
  const GreyPlane& image_;
  Matrix3d H_;
};

bool is_border(const TagCells& cells, int row, int column) {
  const int last = cells.side - 1 - cells.border;
  return row < cells.border || column < cells.border || row > last || column > last;
}

std::optional<TagSamples> sampled(const Sampler& sampler, const TagCells& cells, double gap) {
  TagSamples result;
  for (int row = 0; row < cells.side; ++row) {
    for (int column = 0; column < cells.side; ++column) {
      const Vector2d middle(column + 0.5, row + 0.5);
      const auto value = sampler.at(middle);
      if (!value) return std::nullopt;
      result.cells.push_back(*value);
      if (is_border(cells, row, column)) result.black.emplace_back(middle, *value);
    }
  }
  for (int k = 1; k + 1 < cells.side; ++k) {  // the middle of the gap, all around
    const double along = k + 0.5, far = cells.side + gap / 2;
    for (const Vector2d& at : {Vector2d(along, -gap / 2), Vector2d(along, far),
                               Vector2d(-gap / 2, along), Vector2d(far, along)}) {
      if (const auto value = sampler.at(at)) result.white.emplace_back(at, *value);
    }
  }
  if (result.white.size() < static_cast<std::size_t>(cells.side)) return std::nullopt;
  return result;
}

// The bits of the code, row by row, 1 for white; none where the border is not black.
std::optional<std::uint64_t> bits_of(const TagSamples& samples, const TagCells& cells) {
  const Vector3d black = plane_of(samples.black), white = plane_of(samples.white);
  std::uint64_t code = 0;
  int wrong = 0, border = 0;
  for (int row = 0; row < cells.side; ++row) {
    for (int column = 0; column < cells.side; ++column) {
      const Vector3d at(1, column + 0.5, row + 0.5);
      const double low = black.dot(at), high = white.dot(at);
      if (high - low < kLeastStep) return std::nullopt;
      const double value = samples.cells[static_cast<std::size_t>(row * cells.side + column)];
      const bool is_white = value > (low + high) / 2;
      if (is_border(cells, row, column)) {
        ++border;
        wrong += is_white ? 1 : 0;
      } else {
        code = 2 * code + (is_white ? 1 : 0);
      }
    }
  }
  if (wrong > kWrongBorder * border) return std::nullopt;
  return code;
}

// The least distance of two codes, in any turn, and of a code to itself turned.
int least_distance(const std::vector<PrintedTag>& tags, int side) {
  int least = side * side;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    std::uint64_t code = tags[i].code;
    for (int turn = 0; turn < 4; ++turn, code = turned(code, side)) {
      for (std::size_t j = i + (turn == 0 ? 1 : 0); j < tags.size(); ++j) {
        least = std::min(least, std::popcount(code ^ tags[j].code));
      }
    }
  }
  return least;
}

}  // namespace

TagReader::TagReader(const Target& target)
    : target_(target), tags_(printed_tags(target)), cells_(tag_cells(target)) {
  const int side = cells_.side - 2 * cells_.border;
  most_wrong_ =
      std::min((least_distance(tags_, side) - 1) / 2, static_cast<int>(kWrongBits * side * side));
}

bool TagReader::proves(int wrong_bits) const {
  const int bits = (cells_.side - 2 * cells_.border) * (cells_.side - 2 * cells_.border);
  double patterns = 1, near = 1;  // with so many wrong bits
  for (int k = 1; k <= wrong_bits; ++k) {
    patterns *= static_cast<double>(bits - k + 1) / k;
    near += patterns;
  }
  return near * 4 * static_cast<double>(tags_.size()) < 1e-7 * std::exp2(bits);
}

std::optional<ReadTag> TagReader::read(const GreyPlane& image, const Corners& corners) const {
  // From cells to the unit square of the corners. The gap is white, in cells.
  const double cell = target_.tag_size / cells_.side;
  const bool inside = target_.kind == TargetKind::charuco;
  const double gap = inside ? (target_.column_spacing - target_.tag_size) / 2 / cell
                            : target_.tag_spacing * target_.tag_size / cell;
  const double whole = inside ? target_.column_spacing / cell : cells_.side;
  Matrix3d to_unit = Matrix3d::Identity();
  to_unit.diagonal().head<2>().setConstant(1 / whole);
  if (inside) to_unit.topRightCorner<2, 1>().setConstant(gap / whole);
  const auto samples = sampled(Sampler(image, square_to(corners) * to_unit), cells_, gap);
  if (!samples) return std::nullopt;
  const auto seen = bits_of(*samples, cells_);
  if (!seen) return std::nullopt;
  const int side = cells_.side - 2 * cells_.border;
  std::uint64_t code = *seen;
  for (int turn = 0; turn < 4; ++turn, code = turned(code, side)) {
    for (std::size_t tag = 0; tag < tags_.size(); ++tag) {
      const int wrong = std::popcount(code ^ tags_[tag].code);
      if (wrong <= most_wrong_) return ReadTag{static_cast<int>(tag), turn, wrong};
    }
  }
  return std::nullopt;
}

}  // namespace chasles
