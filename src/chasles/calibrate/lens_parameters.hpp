#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// A lens model with a number of coefficients: what a calibration estimates.
struct LensForm {
  Distortion distortion = Distortion::kNone;
  std::size_t coefficients = 0;

  int parameters() const { return 4 + static_cast<int>(coefficients); }
  bool operator==(const LensForm&) const = default;
};

/// "radtan" with its shortest list of coefficients, "radtan:8" with 8. Throws UsageError that names
/// `setting`.
LensForm lens_form(const std::string& text, const std::string& setting);
std::string name_of(const LensForm& form);
LensForm form_of(const Camera& camera);

/// (fx, fy, cx, cy, coefficients) of a camera, and their names.
Eigen::VectorXd lens_parameters(const Camera& camera);
std::vector<std::string> lens_parameter_names(const LensForm& form);
/// The camera with these. None if a focal length is not positive or coefficients are outside of the
/// model's limits.
std::optional<Camera> with_lens_parameters(Camera camera, const Eigen::VectorXd& parameters);

/// Other coordinates of the same parameters, in which a search goes straight and covariances hold:
/// the focal lengths on the axis, and for ds and for omni with five coefficients the radius on the
/// image plane as a series of the angle. With the models' own, xi, the focal lengths and the radial
/// coefficients lie in a curved valley.
Eigen::VectorXd search_coordinates(const LensForm& form, const Eigen::VectorXd& parameters);
Eigen::VectorXd from_search_coordinates(const LensForm& form, const Eigen::VectorXd& coordinates);
/// d parameters / d coordinates.
Eigen::MatrixXd by_search_coordinates(const LensForm& form, const Eigen::VectorXd& coordinates);

/// What is known of a parameter before any measurement.
struct LensPrior {
  int parameter = 0;
  double mean = 0, sigma = 1;
};
/// Of the parameters that the corners of some lenses hardly show, because others do nearly the
/// same: xi, and the denominator of radtan with eight coefficients.
std::vector<LensPrior> lens_priors(const LensForm& form);

/// The camera with a step of its coordinates; none as with_lens_parameters().
std::optional<Camera> moved(const Camera& camera, const Eigen::VectorXd& step);

/// Bearings in the frame of a camera and their pixels.
struct PixelDirection {
  Eigen::Vector3d bearing;
  Eigen::Vector2d pixel;
};

/// The parameters of another lens model that map these bearings to these pixels best. `like`: the
/// size of the images, and about its focal lengths on the axis and principal point. Bearings beyond
/// 80 degrees do not count for a model that ends before 90. Several, best first, for a model that
/// maps nearly the same with different parameters; none without enough bearings.
std::vector<Camera> fitted_lenses(const Camera& like, const LensForm& form,
                                  const std::vector<PixelDirection>& directions);

}  // namespace chasles
