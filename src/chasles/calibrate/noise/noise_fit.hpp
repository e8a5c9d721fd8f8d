#pragma once

#include <span>

#include <Eigen/Core>

#include <chasles/calibrate/noise/allan.hpp>
#include <chasles/calibrate/noise/cosine_powers.hpp>

namespace chasles {

/// One of N, B and K: its value with a standard deviation, or a limit where the data do not show
/// it.
struct NoiseTerm {
  bool shown = false;
  double value = 0;           ///< where it is not shown, the most likely value, often 0
  double relative_sigma = 0;  ///< where it is shown: sigma of the value's logarithm
  double limit = 0;           ///< upper limit with a probability of 95 %, one-sided
};

/// The noise of a signal of a standstill.
struct NoiseFit {
  NoiseTerm white;        ///< N [unit/sqrt(Hz)]
  NoiseTerm instability;  ///< B [unit]
  NoiseTerm walk;         ///< K [unit/s/sqrt(Hz)]
  /// Covariance of ln N and ln K; 0 for one that is not shown.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  NoisePower power;  ///< of the parts that are shown
  /// K of the fit without B: a filter has no B, and its walk takes in what is slow.
  double walk_without_instability = 0;
  double white_up_to = 0;  ///< the fit ends at this frequency [Hz]
  /// Squared residuals of bands a third of an octave wide per degree of freedom, to 2 % of their
  /// power: 1 if the model holds. Where it is significantly larger (a probability of 1e-4), the
  /// sigmas and limits have grown by its root.
  double misfit = 1;
};

/// Maximises the likelihood of the bands (cosine_powers(); of several spans, all bands together)
/// over N^2, B^2 and K^2, none negative. A part is shown where the likelihood without it is worse
/// by more than 3 sigma (twice its logarithm by 9). B is looked for first, since filters have N
/// and K alone; K then without B, unless B is shown. Sigmas are those of the Fisher information;
/// limits are those of the profile likelihood.
///
/// Where the misfit is significant, the highest third of an octave is left out, and so on: above,
/// there is vibration, or the filter that a sensor may have. At least 64 coefficients up to 1 Hz or
/// more stay.
/// Needs at least 8 coefficients of a power above 0; throws InputError otherwise.
NoiseFit fit_noise(std::span<const PowerBand> bands);

}  // namespace chasles
