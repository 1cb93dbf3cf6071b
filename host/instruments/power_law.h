// SPDX-License-Identifier: Apache-2.0
// How a quantity grows with another: the exponent of a power law through measured points.
#pragma once
#include <optional>
#include <span>
#include <string>

namespace eikon {

/// An exponent, and half of its 95 % confidence interval.
struct Exponent {
  double value = 0, doubt = 0;
};

/// y = c x^exponent, fitted by least squares to the logarithms.
struct PowerLaw {
  Exponent exponent;
  /// A place at which the exponent changes, if two exponents describe the points significantly
  /// better than one.
  struct Bend {
    double x = 0;
    Exponent before, after;
  };
  std::optional<Bend> bend{};
};

/// Fits at least three points of positive coordinates, x increasing; nothing for fewer. The doubt
/// comes from how the points scatter about the line, by Student's t distribution. A bend is looked
/// for at every point that has two or more on either side, and is significant at 1 % after
/// Bonferroni.
[[nodiscard]] std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y);

/// "-1.02 +- 0.03", or "-1.52 +- 0.05 up to 16, -1.01 +- 0.02 beyond".
[[nodiscard]] std::string in_words(const PowerLaw& law);

}  // namespace eikon
