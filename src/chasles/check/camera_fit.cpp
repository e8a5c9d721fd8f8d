#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/check/camera_fit.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kAgreement = 0.05;  // of the scales of two rotations
constexpr double kOtherScale = 0.06;
constexpr double kLeastUnit = 0.2, kMostUnit = 5;  // beyond, another unit
constexpr double kTurnedAway = 2 * kRadians;
constexpr double kMostGainSigma = 0.025;
constexpr double kTighter = 0.6;        // sigma of an explanation, over the stated one's
constexpr double kTighterTurned = 0.9;  // the same where the rotation then agrees
constexpr double kFarTighter = 0.5;     // of a free lens, over that of a guess
constexpr int kGuessPasses = 3;         // the right guess has converged by then
constexpr int kMostSizeSteps = 5;
constexpr double kSizeConverged = 0.004;
constexpr double kSizeStarts[] = {1, 2.5};

double turned_away(const GyroscopeFit& fit, const Camera& camera) {
  return so3::log(camera.cam_T_imu.R.transpose() * fit.cam_R_imu).norm();
}

bool rotation_agrees(const GyroscopeFit& fit, const Camera& camera) {
  return !fit.mirrored && turned_away(fit, camera) < kTurnedAway;
}

bool is_another_unit(const GyroscopeFit& fit) {
  return fit.gain < kLeastUnit || fit.gain > kMostUnit;
}

// Whether the stated lens leaves something to explain.
bool is_suspicious(const CameraFit& fit, const Camera& camera) {
  if (!fit.stated) return true;
  if (is_another_unit(*fit.stated)) return false;
  const bool scaled = std::abs(fit.stated->gain - 1) > kOtherScale;
  const bool turned = !rotation_agrees(*fit.stated, camera) &&
                      turned_away(*fit.stated, camera) > 3 * fit.stated->rotation_sigma;
  return scaled || turned ||
         (fit.lens && (fit.lens->has_wrong_distortion() ||
                       (fit.lens->is_rolling() && !camera.shutter.is_rolling())));
}

// A guess with its fit.
struct Explained {
  LensGuess guess;
  std::vector<SeenTwice> seen;
  GyroscopeFit fit;
};

bool explains(const GyroscopeFit& fit, const std::optional<GyroscopeFit>& stated,
              const Camera& camera) {
  if (std::abs(fit.gain - 1) > kAgreement || fit.gain_sigma > kMostGainSigma) return false;
  if (!stated) return rotation_agrees(fit, camera);
  const bool turns_back = !rotation_agrees(*stated, camera) && rotation_agrees(fit, camera);
  return fit.gain_sigma < (turns_back ? kTighterTurned : kTighter) * stated->gain_sigma;
}

// The search for a mistake.
class LensSearch {
 public:
  LensSearch(const std::vector<FeatureFrame>& frames, const std::vector<Camera>& cameras,
             int camera, const std::vector<StampedRate>& rates,
             const std::optional<GyroscopeFit>& stated)
      : frames_(frames), cameras_(cameras), camera_(camera), rates_(rates), stated_(stated) {}

  std::optional<Explained> best() {
    for (LensGuess& guess : lens_guesses(camera())) consider(fitted(std::move(guess)));
    for (const double start : kSizeStarts) consider(sized(start, false));
    if (const auto size = size_of_images(camera())) consider(sized(*size, true));
    return std::move(best_);
  }

 private:
  const Camera& camera() const { return cameras_[static_cast<std::size_t>(camera_)]; }

  std::optional<Explained> fitted(LensGuess guess) const {
    std::vector<Camera> cameras = cameras_;
    cameras[static_cast<std::size_t>(camera_)] = guess.camera;
    auto seen = seen_twice(frames_, cameras, camera_);
    const auto fit = fit_gyroscope(seen, rates_, kGuessPasses);
    if (!fit) return std::nullopt;
    return Explained{.guess = std::move(guess), .seen = std::move(seen), .fit = *fit};
  }

  // Images rotate faster, in the ratio of the focal lengths, where the stated one is too short.
  std::optional<Explained> sized(double size, bool moves_centre) const {
    std::optional<Explained> last;
    for (int k = 0; k < kMostSizeSteps; ++k) {
      auto guess = sized_guess(camera(), size, moves_centre);
      if (!guess) return std::nullopt;
      last = fitted(std::move(*guess));
      if (!last || is_another_unit(last->fit)) return std::nullopt;
      if (std::abs(last->fit.gain - 1) < kSizeConverged) break;
      size *= last->fit.gain;
    }
    return std::abs(last->guess.camera.fx / camera().fx - 1) > kOtherScale ? last : std::nullopt;
  }

  void consider(std::optional<Explained> found) {
    if (!found || !explains(found->fit, stated_, camera())) return;
    if (best_ && best_->fit.gain_sigma <= found->fit.gain_sigma) return;
    best_ = std::move(found);
  }

  const std::vector<FeatureFrame>& frames_;
  const std::vector<Camera>& cameras_;
  int camera_;
  const std::vector<StampedRate>& rates_;
  const std::optional<GyroscopeFit>& stated_;
  std::optional<Explained> best_;
};

// The lens of fit_lens(), as an explanation.
LensGuess free_lens(const LensFit& lens, const Camera& stated) {
  const Measured error = lens.radial_at_edge();
  const double edge = lens.edge / kRadians;
  return {.camera = stated,
          .what = fmt::format("its lens is not the stated one: at {:.0f} deg from the axis rays "
                              "are {:.1f} +- {:.1f} deg farther {} than the distortion says",
                              edge, edge * std::abs(error.value), edge * error.sigma,
                              error.value > 0 ? "out" : "in"),
          .advice =
              "check the lens model and its coefficients: are they there, in their order, and of "
              "this camera?",
          .value = 100 * std::abs(error.value),
          .threshold = 100 * LensFit::kMostAtEdge,
          .unit = "%"};
}

void explain_by_lens(const std::vector<SeenTwice>& seen, const std::vector<StampedRate>& rates,
                     const Camera& camera, std::optional<Explained>& best, CameraFit& fit) {
  if (!fit.lens || !fit.lens->has_wrong_distortion()) return;
  LensGuess guess = free_lens(*fit.lens, camera);
  auto without = mended(seen, *fit.lens);
  const auto again = fit_gyroscope(without, rates);
  const bool good = again && explains(*again, fit.stated, camera);
  if (best && !(good && again->gain_sigma < kFarTighter * best->fit.gain_sigma)) return;
  if (good) {
    best = Explained{.guess = std::move(guess), .seen = std::move(without), .fit = *again};
    return;
  }
  fit.mistake = std::move(guess);
  fit.gyroscope.reset();
}

// The fit of the lens has local minima at other rotations and offsets, and a gyroscope fit of
// points in a plane may begin at one: it begins at what is stated as well.
void fit_from_stated_rotation(const std::vector<SeenTwice>& seen,
                              const std::vector<StampedRate>& rates, const Camera& camera,
                              CameraFit& fit) {
  if (!fit.stated || fit.stated->mirrored || is_another_unit(*fit.stated)) return;
  GyroscopeFit as_stated = *fit.stated;
  as_stated.cam_R_imu = camera.cam_T_imu.R;
  as_stated.gain = 1;
  as_stated.bias_cam.setZero();
  for (const double offset : {fit.stated->offset, 0.0}) {
    as_stated.offset = offset;
    const auto other = fit_lens(seen, rates, as_stated);
    if (other && (!fit.lens || other->cost < fit.lens->cost)) fit.lens = other;
  }
}

// Points in a plane leave two rotations of an image, of which the one nearer to the start is found;
// the fit of the lens, with all images in one, distinguishes them. It also has the readout, without
// which the lines of a rolling shutter turn the images.
void refit_from_lens(const std::vector<SeenTwice>& seen, const std::vector<StampedRate>& rates,
                     CameraFit& fit) {
  if (!fit.lens) return;
  const LensFit& lens = *fit.lens;
  const GyroscopeFit start{.cam_R_imu = lens.cam_R_imu,
                           .gain = lens.gain.value,
                           .bias_cam = lens.bias_cam,
                           .offset = lens.offset.value};
  const auto again =
      fit_gyroscope_from(start, lens.is_rolling() ? unrolled(seen, rates, lens) : seen, rates);
  if (again && again->gain_sigma < fit.stated->gain_sigma) fit.stated = again;
}

// Whether the stated calibration leaves nothing to explain, with a rotation that is well known.
bool agrees_as_stated(const CameraFit& fit, const Camera& camera) {
  return fit.stated && fit.lens && !fit.lens->is_rolling() &&
         rotation_agrees(*fit.stated, camera) && fit.stated->rotation_sigma < kTurnedAway &&
         std::abs(fit.stated->gain - 1) < kOtherScale && fit.stated->gain_sigma < kMostGainSigma;
}

// Signs of the axes of which one is a mirror image.
const Eigen::Vector3d kMirrorSigns[] = {{-1, -1, -1}, {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}};

// Whether other signs explain the images.
bool explain_by_signs(const std::vector<SeenTwice>& seen, const std::vector<StampedRate>& rates,
                      const Camera& camera, CameraFit& fit) {
  if (!fit.stated || rotation_agrees(*fit.stated, camera)) return false;
  for (const Eigen::Vector3d& signs : kMirrorSigns) {
    std::vector<StampedRate> changed = rates;
    for (StampedRate& rate : changed) rate.rate_imu = signs.cwiseProduct(rate.rate_imu);
    const auto again = fit_gyroscope(seen, changed, kGuessPasses);
    if (!again || !explains(*again, fit.stated, camera)) continue;
    if (!rotation_agrees(*again, camera)) continue;
    fit.signs = signs;
    fit.gyroscope = again;
    fit.lens = fit_lens(seen, changed, *again);
    return true;
  }
  return false;
}

}  // namespace

bool CameraFit::agrees() const {
  return gyroscope && gyroscope->gain_sigma < kMostGainSigma * std::abs(gyroscope->gain);
}

Measured CameraFit::offset() const {
  Measured middle{gyroscope->offset, gyroscope->offset_sigma};
  if (lens && lens->is_rolling()) middle = lens->offset;
  middle.value -= shutter.readout / 2;
  return middle;
}

std::optional<CameraFit> fit_camera(const std::vector<FeatureFrame>& frames,
                                    const std::vector<Camera>& cameras, int camera,
                                    const std::vector<StampedRate>& rates) {
  const Camera& stated = cameras[static_cast<std::size_t>(camera)];
  const auto seen = seen_twice(frames, cameras, camera);
  CameraFit fit{.stated = fit_gyroscope(seen, rates), .shutter = stated.shutter};
  if (fit.stated) fit.lens = fit_lens(seen, rates, *fit.stated);
  if (!agrees_as_stated(fit, stated)) {
    fit_from_stated_rotation(seen, rates, stated, fit);
    refit_from_lens(seen, rates, fit);
  }
  fit.gyroscope = fit.stated;
  if (!is_suspicious(fit, stated) || explain_by_signs(seen, rates, stated, fit)) return fit;
  auto best = LensSearch(frames, cameras, camera, rates, fit.stated).best();
  explain_by_lens(seen, rates, stated, best, fit);
  if (best) {
    fit.mistake = std::move(best->guess);
    fit.gyroscope = best->fit;
    fit.lens = fit_lens(best->seen, rates, best->fit);
  }
  if (!fit.stated && !fit.mistake) return std::nullopt;
  return fit;
}

}  // namespace chasles
