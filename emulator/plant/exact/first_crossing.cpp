#include "emulator/plant/exact/first_crossing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

namespace torsio::emulator {
namespace {

constexpr std::size_t kCount = kPolynomialDegree + 1;
using Bernstein = std::array<double, kCount>;
using Basis = std::array<std::array<double, kCount>, kCount>;

constexpr double binomial(std::size_t n, std::size_t k) {
  double result = 1.0;
  for (std::size_t i = 1; i <= k; ++i) {
    result = result * static_cast<double>(n - k + i) / static_cast<double>(i);
  }
  return result;
}

/// Bernstein coefficient i is the sum over k <= i of C(i, k) / C(n, k) times power coefficient k.
constexpr Basis make_basis() {
  Basis basis{};
  for (std::size_t i = 0; i < kCount; ++i) {
    for (std::size_t k = 0; k <= i; ++k) {
      basis[i][k] = binomial(i, k) / binomial(kPolynomialDegree, k);
    }
  }
  return basis;
}
constexpr Basis kBasis = make_basis();

/// Without the highest terms that count for nothing.
std::size_t degree_of(const Polynomial& polynomial) {
  std::size_t degree = kCount - 1;
  while (degree > 1 && std::abs(polynomial[degree]) <= 1e-18 * std::abs(polynomial[0])) --degree;
  return degree;
}

/// The root in (low, high), where the polynomial changes once from positive to negative. Newton's
/// method begins at s; a bisection replaces a step that leaves the bracket.
double refine(const Polynomial& polynomial, double low, double high, double s) {
  const std::size_t degree = degree_of(polynomial);
  if (!(s > low && s < high)) s = 0.5 * (low + high);
  for (int iteration = 0; iteration < 100; ++iteration) {
    double value = polynomial[degree];
    double slope = 0.0;
    for (std::size_t k = degree; k-- > 0;) {
      slope = slope * s + value;
      value = value * s + polynomial[k];
    }
    (value > 0.0 ? low : high) = s;
    double next = s - value / slope;
    double enough = 1e-10;  // Newton squares what is missing
    if (!(next > low && next < high)) {
      next = 0.5 * (low + high);
      enough = 1e-15;
    }
    if (std::abs(next - s) <= enough || next <= low || next >= high) return next;
    s = next;
  }
  return s;
}

/// The crossing of a polynomial that falls all the way. The parabola of its first terms is a good
/// begin.
std::optional<double> crossing_of_fall(const Polynomial& polynomial, double tolerance) {
  if (evaluate(polynomial, 1.0) >= -tolerance) return std::nullopt;
  const double fall = -0.5 * polynomial[1];
  const double square = std::max(0.0, fall * fall - polynomial[0] * polynomial[2]);
  return refine(polynomial, 0.0, 1.0, polynomial[0] / (fall + std::sqrt(square)));
}

Bernstein over_bernstein(const Polynomial& polynomial) {
  Bernstein b{};
  for (std::size_t i = 0; i < kCount; ++i) {
    for (std::size_t k = 0; k <= i; ++k) b[i] += kBasis[i][k] * polynomial[k];
  }
  return b;
}

struct Search {
  const Polynomial& polynomial;
  double tolerance;

  std::optional<double> operator()(const Bernstein& b, double begin, double width) const {
    int changes = 0;
    bool positive = true;
    bool any = false;
    for (const double coefficient : b) {
      if (std::abs(coefficient) <= tolerance) continue;
      if (!any && coefficient < 0.0) return begin;
      any = true;
      if ((coefficient > 0.0) != positive) {
        positive = !positive;
        ++changes;
      }
    }
    if (changes == 0) return std::nullopt;
    if (changes == 1) return refine(polynomial, begin, begin + width, begin + 0.5 * width);
    if (width < 1e-15) return begin;

    // De Casteljau's scheme gives the coefficients over both halves at once.
    Bernstein left{};
    Bernstein right = b;
    for (std::size_t level = 0; level < kCount; ++level) {
      left[level] = right[0];
      for (std::size_t i = 0; i + level + 1 < kCount; ++i) {
        right[i] = 0.5 * (right[i] + right[i + 1]);
      }
    }
    if (const auto found = (*this)(left, begin, 0.5 * width)) return found;
    return (*this)(right, begin + 0.5 * width, 0.5 * width);
  }
};

}  // namespace

double evaluate(const Polynomial& polynomial, double s) {
  double result = 0.0;
  for (std::size_t k = kCount; k-- > 0;) result = result * s + polynomial[k];
  return result;
}

std::optional<double> first_crossing(const Polynomial& polynomial, double tolerance) {
  // Most curves are nearly straight, and simpler bounds than Bernstein's settle them. The first
  // coefficient that counts decides alone if it outweighs all that follow.
  double rest = 0.0;
  for (std::size_t k = 1; k < kCount; ++k) rest += std::abs(polynomial[k]);
  // Also false for NaN, with which the search below would never end.
  if (!(std::abs(polynomial[0]) + rest < std::numeric_limits<double>::infinity())) [[unlikely]] {
    throw std::runtime_error(
        "the plant moves beyond all numbers: its parameters, or the torques on it, do not go "
        "together");
  }
  for (std::size_t k = 0; k < kCount; ++k) {
    if (std::abs(polynomial[k]) > tolerance) {
      if (polynomial[k] < 0.0) return 0.0;
      if (polynomial[k] >= rest) return std::nullopt;
      break;
    }
    if (k + 1 < kCount) rest -= std::abs(polynomial[k + 1]);
  }
  double rest_of_slope = 0.0;
  for (std::size_t k = 2; k < kCount; ++k) {
    rest_of_slope += static_cast<double>(k) * std::abs(polynomial[k]);
  }
  if (polynomial[0] > tolerance && -polynomial[1] > rest_of_slope) {
    return crossing_of_fall(polynomial, tolerance);
  }
  return Search{polynomial, tolerance}(over_bernstein(polynomial), 0.0, 1.0);
}

}  // namespace torsio::emulator
