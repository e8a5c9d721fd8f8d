#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/loop/map_fusion.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Keeps the covariance of a difference regular where no error is a point's own [m^2].
constexpr double kLeastOwn = 1e-12;

// Of the point that was found again, about the first one.
Matrix3d other_point(const MapPoint& point) {
  if (point.appearance.empty()) return Matrix3d::Zero();
  const double pixel = 1e-3 * std::exp2(point.appearance.views().front().level / 2.0);  // [m]
  return kOtherPoint * kOtherPoint * pixel * pixel * Matrix3d::Identity();
}

}  // namespace

MapFusion::MapFusion(const LandmarkMap& a, const LandmarkMap& b, const SE3& a_T_b,
                     std::span<const Match> matches)
    : a_(a), b_(b), place_{.world_T_map = a_T_b} {
  for (const Match& match : matches) {
    place_.pivot += a_T_b * b.points[static_cast<std::size_t>(match.seen)].p_map /
                    static_cast<double>(matches.size());
  }
  place_b();
}

MapFusion::MapFusion(const LandmarkMap& a, const LandmarkMap& b, std::span<const Match> common)
    : a_(a),
      b_(b),
      place_{.world_T_map = {}, .heading_sigma = 0, .position_sigma = 0},
      common_(b.points.size()) {
  for (const Match& match : common) common_[static_cast<std::size_t>(match.seen)] = true;
  place_b();
}

void MapFusion::place_b() {
  std::vector<int> all(b_.points.size());
  std::iota(all.begin(), all.end(), 0);
  placed_b_ = placed(b_, all, place_);
}

MatrixXd MapFusion::rows_a(int point) const {
  MatrixXd rows = MatrixXd::Zero(3, size());
  rows.leftCols(a_.covariance.rank()) =
      a_.covariance.shared().middleRows<3>(3 * static_cast<Index>(point));
  return rows;
}

MatrixXd MapFusion::rows_b(int point) const {
  MatrixXd rows = MatrixXd::Zero(3, size());
  rows.rightCols(placed_b_.shared.cols()) =
      placed_b_.shared.middleRows<3>(6 + 3 * static_cast<Index>(point));
  return rows;
}

MapFusion::Difference MapFusion::difference(const Match& match) const {
  const MapPoint& point = a_.points[static_cast<std::size_t>(match.point)];
  const Matrix3d& D_a = a_.covariance.own()[static_cast<std::size_t>(match.point)];
  const bool is_common = !common_.empty() && common_[static_cast<std::size_t>(match.seen)];
  Difference result{.d = p_b(match.seen) - point.p_map,
                    .H = rows_b(match.seen) - rows_a(match.point),
                    .V = D_a + placed_b_.own[static_cast<std::size_t>(match.seen)] +
                         (is_common ? kLeastOwn * Matrix3d::Identity() : other_point(point)),
                    .gain = {}};
  result.gain = D_a * result.V.inverse();
  return result;
}

MapFusion::Posterior MapFusion::solve(std::span<const Match> matches) const {
  MatrixXd information = MatrixXd::Identity(size(), size());
  VectorXd b = VectorXd::Zero(size());
  double squares = 0;
  for (const Match& match : matches) {
    const Difference one = difference(match);
    const Eigen::LLT<Matrix3d> V(one.V);
    const MatrixXd whitened = V.matrixL().solve(one.H);
    const Vector3d d = V.matrixL().solve(one.d);
    information += whitened.transpose() * whitened;
    b -= whitened.transpose() * d;
    squares += d.squaredNorm();
  }
  const Eigen::LLT<MatrixXd> llt(information);
  Posterior result;
  result.mean = llt.solve(b);
  result.root = llt.matrixU().solve(MatrixXd::Identity(size(), size()));
  result.nis = squares - b.dot(result.mean);
  return result;
}

void MapFusion::relinearise(std::span<const Match> matches) {
  constexpr int kSteps = 3;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector4d by = solve(matches).mean.tail<4>();
    const Matrix3d turn = so3::exp({0, 0, place_.heading_sigma * by(0)});
    SE3& a_T_b = place_.world_T_map;
    a_T_b.R = turn * a_T_b.R;
    a_T_b.p = place_.pivot + turn * (a_T_b.p - place_.pivot) + place_.position_sigma * by.tail<3>();
    place_b();
  }
}

double MapFusion::square(const Match& match, const Posterior& given, bool is_one) const {
  const Difference one = difference(match);
  const MatrixXd by_root = one.H * given.root;
  const Matrix3d P = by_root * by_root.transpose();
  const Matrix3d S = is_one ? Matrix3d(one.V - P) : Matrix3d(one.V + P);
  const Vector3d r = one.d + one.H * given.mean;
  return r.dot(S.ldlt().solve(r));
}

std::vector<MapFusion::Whereabouts> MapFusion::points_of_a(const Posterior& given) const {
  std::vector<Whereabouts> result;
  for (int i = 0; i < static_cast<int>(a_.points.size()); ++i) {
    const MapPoint& point = a_.points[static_cast<std::size_t>(i)];
    const MatrixXd rows = rows_a(i);
    result.push_back({.p = point.p_map + rows * given.mean,
                      .variance = (rows * given.root).squaredNorm() +
                                  a_.covariance.own()[static_cast<std::size_t>(i)].trace(),
                      .appearance = point.appearance});
  }
  return result;
}

std::vector<MapFusion::Whereabouts> MapFusion::points_of_b(const Posterior& given) const {
  std::vector<Whereabouts> result;
  for (int i = 0; i < static_cast<int>(b_.points.size()); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const MatrixXd rows = rows_b(i);
    result.push_back({.p = p_b(i) + rows * given.mean,
                      .variance = (rows * given.root).squaredNorm() + placed_b_.own[index].trace(),
                      .appearance = b_.points[index].appearance.turned(place_.world_T_map.R)});
  }
  return result;
}

JoinedMaps MapFusion::joined(std::span<const Match> matches) const {
  const Posterior posterior = solve(matches);
  JoinedMaps result{.map = {},
                    .a_T_b = place_.world_T_map,
                    .matches = static_cast<int>(matches.size()),
                    .nis = posterior.nis};
  const auto n_a = static_cast<Index>(a_.points.size());
  std::vector<const Match*> of_a(a_.points.size());
  std::vector<bool> taken(b_.points.size());
  for (const Match& match : matches) {
    of_a[static_cast<std::size_t>(match.point)] = &match;
    taken[static_cast<std::size_t>(match.seen)] = true;
  }
  LandmarkMap& map = result.map;
  map.sessions = a_.sessions;
  map.sessions.insert(map.sessions.end(), b_.sessions.begin(), b_.sessions.end());
  std::vector<Matrix3d> own;
  MatrixXd shared(3 * (n_a + static_cast<Index>(b_.points.size())), size());
  const auto add = [&](MapPoint point, const MatrixXd& rows, const Matrix3d& D) {
    shared.middleRows<3>(3 * static_cast<Index>(map.points.size())) = rows;
    point.p_map += rows * posterior.mean;
    own.push_back((D + D.transpose()) / 2);
    map.points.push_back(std::move(point));
  };
  for (std::size_t i = 0; i < a_.points.size(); ++i) {
    const auto index = static_cast<int>(i);
    MapPoint point = a_.points[i];
    const Matrix3d& D = a_.covariance.own()[i];
    if (of_a[i] == nullptr) {
      add(std::move(point), rows_a(index), D);
      continue;
    }
    const Difference one = difference(*of_a[i]);
    const MapPoint& other = b_.points[static_cast<std::size_t>(of_a[i]->seen)];
    point.p_map += one.gain * one.d;
    point.observations += other.observations;
    const Appearance in_a = other.appearance.turned(place_.world_T_map.R);
    for (const PatchView& view : in_a.views()) point.appearance.add(view);
    add(std::move(point), rows_a(index) + one.gain * one.H, D - one.gain * D);
  }
  for (std::size_t i = 0; i < b_.points.size(); ++i) {
    if (taken[i]) continue;
    const auto index = static_cast<int>(i);
    MapPoint point = b_.points[i];
    point.p_map = p_b(index);
    point.session += static_cast<int>(a_.sessions.size());
    point.appearance = point.appearance.turned(place_.world_T_map.R);
    if (point.appearance.empty()) continue;
    add(std::move(point), rows_b(index), placed_b_.own[i]);
  }
  shared.conservativeResize(3 * static_cast<Index>(own.size()), Eigen::NoChange);
  map.covariance =
      JointCovariance(std::move(own), dense::product(shared, posterior.root)).reduced({});
  return result;
}

}  // namespace chasles
