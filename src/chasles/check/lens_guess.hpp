#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// A mistake that calibrations have, undone.
struct LensGuess {
  Camera camera;            ///< the stated one with the mistake undone
  std::string what = {};    ///< what is wrong with the stated one: "its focal length ..."
  std::string advice = {};  ///< recommended action
  double value = 0;         ///< how far the stated one is off, in `unit`
  double threshold = 0;     ///< from where on that is a mistake
  std::string unit = {};    ///< "%" of focal lengths or of angles at the edge, or "px"
};

/// The mistakes that a stated camera may have, other than its size: a principal point with x and y
/// exchanged or far from the middle, unequal focal lengths, coefficients in another order, of
/// another sign, or of another model, or of images without distortion. Each differs from the stated
/// camera.
std::vector<LensGuess> lens_guesses(const Camera& stated);

/// The size of the images, over that of the calibration, where the principal point is as far from
/// their middle as it would be then. Nothing where it is near the middle.
std::optional<double> size_of_images(const Camera& stated);

/// Another focal length, by the factor `size`; with the principal point, if it moves: a calibration
/// of images of another size. Nothing if that moves it far from the middle of the images.
std::optional<LensGuess> sized_guess(const Camera& stated, double size, bool moves_centre);

}  // namespace chasles
