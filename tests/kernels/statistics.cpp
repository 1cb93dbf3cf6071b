// SPDX-License-Identifier: Apache-2.0
#include "kernels/statistics.h"

#include <cmath>
#include <sstream>

namespace eikon::test {
namespace {

// Upper tail of the chi-square distribution: the regularised incomplete gamma function, by its
// series below the mean and by Lentz's continued fraction above [Press et al., Numerical Recipes,
// section 6.2].
double upper_gamma(double a, double x) {
  if (x <= 0) return 1;
  const double scale = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (double n = a + 1; term > sum * 1e-16; ++n) sum += term *= x / n;
    return 1 - sum * scale;
  }
  double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
  for (int i = 1; i < 10000; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = 1 / (an * d + b);
    c = b + an / c;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return scale * h;
}

}  // namespace

double sidak(std::size_t count) { return -std::expm1(std::log1p(-kSignificance) / double(count)); }

ChiSquare chi_square(const std::vector<double>& observed, const std::vector<double>& expected) {
  ChiSquare result;
  std::ostringstream table;
  double pooled_observed = 0, pooled_expected = 0;
  std::size_t bins = 0;
  const auto add = [&](double o, double e) {
    result.statistic += (o - e) * (o - e) / e;
    ++bins;
  };
  for (std::size_t i = 0; i < observed.size(); ++i) {
    table << "bin " << i << ": expected " << expected[i] << ", observed " << observed[i] << '\n';
    if (expected[i] == 0 && observed[i] > 0) {
      result.p_value = 0;
      result.table = "bin " + std::to_string(i) + " expects nothing and has " + std::to_string(observed[i]);
      return result;
    }
    if (expected[i] >= 5) {
      add(observed[i], expected[i]);
    } else {
      pooled_observed += observed[i];
      pooled_expected += expected[i];
    }
  }
  if (pooled_expected > 0) add(pooled_observed, pooled_expected);
  result.degrees = double(bins) - 1;
  result.p_value = upper_gamma(result.degrees / 2, result.statistic / 2);
  result.table = table.str();
  return result;
}

Mean mean_of(const std::vector<double>& values) {
  const double count = double(values.size());
  double sum = 0;
  for (const double x : values) sum += x;
  const double mean = sum / count;
  double squares = 0;
  for (const double x : values) squares += (x - mean) * (x - mean);
  return {mean, std::sqrt(squares / (count - 1) / count)};
}

}  // namespace eikon::test
