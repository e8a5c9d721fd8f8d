#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/target/target.hpp>

namespace chasles {

/// How a printed target differs from its drawing: linear in a few parameters.
struct TargetShape {
  std::vector<std::string> names = {};  ///< of the parameters
  /// Of each corner: d p_target / d parameters, 3 x parameters. Empty: the target is as it is
  /// drawn.
  std::vector<Eigen::Matrix<double, 3, Eigen::Dynamic>> by_parameters = {};
  Eigen::VectorXd sigma = {};  ///< of the parameters before any view
};

/// The middle of a flat target stands out by bend_x and bend_y [m], parabolas along x and y, with a
/// sigma of 0.5 % of its width and height.
TargetShape bent_shape(const std::vector<Eigen::Vector3d>& corners);

/// bent_shape(). The tags of an AprilGrid are larger by growth [m] at each edge, with a
/// sigma of 1 % of a tag: ink spreads, and detectors find edges to one side of the blur.
TargetShape printed_shape(const Target& target);

/// The corners of a target of unknown shape. Drawing and shape must outlive it.
class ShapedCorners {
 public:
  ShapedCorners(const std::vector<Eigen::Vector3d>& drawn, const TargetShape& shape)
      : drawn_(drawn), shape_(shape) {}

  Eigen::Index parameters() const { return shape_.sigma.size(); }
  const Eigen::VectorXd& sigma() const { return shape_.sigma; }  ///< before any view
  /// p_target [m], with these parameters of the shape; none: as drawn.
  Eigen::Vector3d at(int id, const Eigen::VectorXd& shape) const {
    const Eigen::Vector3d& drawn = drawn_[static_cast<std::size_t>(id)];
    return shape.size() > 0 ? Eigen::Vector3d(drawn + by_parameters(id) * shape) : drawn;
  }
  const Eigen::Matrix<double, 3, Eigen::Dynamic>& by_parameters(int id) const {
    return shape_.by_parameters[static_cast<std::size_t>(id)];
  }

 private:
  const std::vector<Eigen::Vector3d>& drawn_;
  const TargetShape& shape_;
};

}  // namespace chasles
