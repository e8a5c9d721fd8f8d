#pragma once

namespace chasles {

/// A step from 0 to 1 over x in [0, 1] whose first three derivatives vanish at both ends. A
/// function composed of such steps and constants has three continuous derivatives.
inline double smoothstep(double x) { return x * x * x * x * (35 + x * (-84 + x * (70 - 20 * x))); }

/// d smoothstep / dx = 140 x^3 (1 - x)^3.
inline double smoothstep_derivative(double x) {
  const double y = x * (1 - x);
  return 140 * y * y * y;
}

/// The integral of smoothstep from 0 to x; 1/2 at x = 1.
inline double smoothstep_integral(double x) {
  return x * x * x * x * x * (7 + x * (-14 + x * (10 - 2.5 * x)));
}

}  // namespace chasles
