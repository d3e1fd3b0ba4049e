/// @file
/// The first moment at which a polynomial becomes negative, found for certain.
#pragma once

#include <array>
#include <optional>

namespace torsio::emulator {

/// p(s) = sum of coefficient k times s^k, for s in [0, 1].
constexpr int kPolynomialDegree = 12;
using Polynomial = std::array<double, kPolynomialDegree + 1>;

[[nodiscard]] double evaluate(const Polynomial& polynomial, double s);

/// The first s in [0, 1] at which the polynomial goes from not negative to negative, to the last
/// bits of s; 0 if it starts out negative or leaves zero downwards. A dip below zero by no more
/// than the tolerance, as rounding makes where a curve touches zero, does not count.
///
/// No crossing is missed, however close two of them are. The coefficients over Bernstein's basis
/// enclose the curve, and their changes of sign bound the number of roots (Descartes). An interval
/// is left only when its roots are certain.
[[nodiscard]] std::optional<double> first_crossing(const Polynomial& polynomial, double tolerance);

}  // namespace torsio::emulator
