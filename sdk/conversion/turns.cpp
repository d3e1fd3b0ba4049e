#include "conversion/turns.hpp"

#include <cmath>

namespace torsio::conversion {

std::int64_t quotient_q32(Exact dividend, Exact divisor) {
  constexpr double kMost = 0x1p30;
  const double about = dividend.value / divisor.value;
  if (std::isnan(about)) return 0;
  if (std::abs(about) >= kMost) return static_cast<std::int64_t>(std::copysign(0x1p62, about));
  const double left = std::fmod(dividend.value, divisor.value);  // exact
  const double whole = std::round((dividend.value - left) / divisor.value);
  const double rest = left + (dividend.rest - whole * divisor.rest);
  return static_cast<std::int64_t>(whole) * (std::int64_t{1} << 32) +
         static_cast<std::int64_t>(std::round(rest / divisor.value * 0x1p32));
}

}  // namespace torsio::conversion
