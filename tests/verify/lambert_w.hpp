#pragma once
/// Lambert's W for x >= 0: w exp(w) = x. It gives the stretch of Hencky's solid under a Cauchy stress when its sides
/// are held: -s = M ln(stretch) / stretch, so that stretch = exp(-W(s/M)) = W(s/M) M/s.

#include <cmath>

namespace berm::verify {

/// Newton's method on w + ln(w) = ln(x) from above.
inline double lambert_w(double x) {
  if (x == 0.0) return 0.0;
  double w = std::log1p(x);
  for (int k = 0; k < 50; ++k) w *= (1.0 + std::log(x / w)) / (1.0 + w);
  return w;
}

}  // namespace berm::verify
