// SPDX-License-Identifier: Apache-2.0
#include "instruments/power_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace eikon {
namespace {

constexpr double kProbability = 0.025;      // on either side of an interval
constexpr double kBendProbability = 0.005;  // likewise, before it is shared among the places of a bend
constexpr double kMinBend = 0.1;            // change of the exponent that is worth a word

/// The value that Student's t exceeds with this probability, below 1/2.
double student_quantile(double probability, double freedom) {
  // With t = sqrt(freedom) tan(u) the density is proportional to cos(u)^(freedom - 1), on a finite
  // range. Simpson's rule.
  const auto exceeded = [&](double t) {
    constexpr int kSteps = 64;
    const double begin = std::atan(t / std::sqrt(freedom)), step = (std::numbers::pi / 2 - begin) / kSteps;
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i)
      sum += (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2) * std::pow(std::cos(begin + i * step), freedom - 1);
    const double scale = std::exp(std::lgamma((freedom + 1) / 2) - std::lgamma(freedom / 2));
    return scale / std::sqrt(std::numbers::pi) * sum * step / 3;
  };
  double low = 0, high = 1;
  while (exceeded(high) > probability) high *= 2;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (exceeded(middle) > probability ? low : high) = middle;
  }
  return high;
}

/// A least-squares fit of y = sum of coefficient[i] * column[i].
template <std::size_t N>
struct Fit {
  std::array<double, N> coefficient{};
  std::array<std::array<double, N>, N> covariance{};  // divided by the variance of a point
  double variance = 0;                                // of a point about the fit
  double freedom = 0;
};

template <std::size_t N>
Fit<N> least_squares(const std::vector<std::array<double, N>>& rows, std::span<const double> y) {
  // The normal equations, beside the unit matrix, by Gauss and Jordan.
  std::array<std::array<double, 2 * N + 1>, N> system{};
  for (std::size_t p = 0; p < rows.size(); ++p)
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) system[i][j] += rows[p][i] * rows[p][j];
      system[i][2 * N] += rows[p][i] * y[p];
    }
  for (std::size_t i = 0; i < N; ++i) system[i][N + i] = 1;
  for (std::size_t pivot = 0; pivot < N; ++pivot) {
    const double scale = 1 / system[pivot][pivot];
    for (double& value : system[pivot]) value *= scale;
    for (std::size_t row = 0; row < N; ++row) {
      if (row == pivot) continue;
      const double factor = system[row][pivot];
      for (std::size_t j = 0; j < system[row].size(); ++j) system[row][j] -= factor * system[pivot][j];
    }
  }
  Fit<N> fit;
  fit.freedom = double(rows.size()) - N;
  for (std::size_t i = 0; i < N; ++i) {
    fit.coefficient[i] = system[i][2 * N];
    for (std::size_t j = 0; j < N; ++j) fit.covariance[i][j] = system[i][N + j];
  }
  for (std::size_t p = 0; p < rows.size(); ++p) {
    double residual = y[p];
    for (std::size_t i = 0; i < N; ++i) residual -= fit.coefficient[i] * rows[p][i];
    fit.variance += residual * residual / fit.freedom;
  }
  return fit;
}

double deviation(double variance) { return std::sqrt(std::max(variance, 0.0)); }

std::optional<PowerLaw::Bend> find_bend(std::span<const double> x, std::span<const double> y) {
  constexpr std::size_t kBeside = 2;
  if (x.size() < 2 * kBeside + 2) return std::nullopt;
  const double places = double(x.size() - 2 * kBeside);
  std::optional<PowerLaw::Bend> found;
  double least = 0;
  for (std::size_t at = kBeside; at + kBeside < x.size(); ++at) {
    std::vector<std::array<double, 3>> rows;
    for (const double each : x) rows.push_back({1, each - x[at], std::max(0.0, each - x[at])});
    const Fit<3> fit = least_squares(rows, y);
    const auto& c = fit.covariance;
    const double change = std::abs(fit.coefficient[2]), doubt = deviation(fit.variance * c[2][2]);
    if (change < kMinBend || change < student_quantile(kBendProbability / places, fit.freedom) * doubt) continue;
    if (found && fit.variance >= least) continue;
    least = fit.variance;
    const double t = student_quantile(kProbability, fit.freedom);
    found = PowerLaw::Bend{
        .x = std::exp(x[at]),
        .before = {fit.coefficient[1], t * deviation(fit.variance * c[1][1])},
        .after = {fit.coefficient[1] + fit.coefficient[2],
                  t * deviation(fit.variance * (c[1][1] + c[2][2] + 2 * c[1][2]))}};
  }
  return found;
}

std::string in_words(const Exponent& exponent) { return fmt::format("{:.2f} +- {:.2f}", exponent.value, exponent.doubt); }

}  // namespace

std::optional<PowerLaw> fit_power_law(std::span<const double> x, std::span<const double> y) {
  if (x.size() < 3) return std::nullopt;
  std::vector<double> log_x, log_y;
  std::vector<std::array<double, 2>> rows;
  for (std::size_t i = 0; i < x.size(); ++i) {
    log_x.push_back(std::log(x[i]));
    log_y.push_back(std::log(y[i]));
    rows.push_back({1, log_x[i] - log_x[0]});
  }
  const Fit<2> fit = least_squares(rows, log_y);
  const double doubt = student_quantile(kProbability, fit.freedom) * deviation(fit.variance * fit.covariance[1][1]);
  return PowerLaw{.exponent = {fit.coefficient[1], doubt}, .bend = find_bend(log_x, log_y)};
}

std::string in_words(const PowerLaw& law) {
  if (!law.bend) return in_words(law.exponent);
  return fmt::format("{} up to {:.3g}, {} beyond", in_words(law.bend->before), law.bend->x, in_words(law.bend->after));
}

}  // namespace eikon
