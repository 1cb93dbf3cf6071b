// SPDX-License-Identifier: Apache-2.0
// Hypothesis tests for what samples. All at a fixed seed: an accepted test stays accepted.
#pragma once
#include <random>
#include <string>
#include <vector>

namespace eikon::test {

/// At least 0, below 1, exact in single precision.
inline float uniform(std::mt19937& random) { return float(random() >> 8) * 0x1p-24F; }

constexpr double kSignificance = 0.01;  // of a whole family of tests

/// Significance of one of `count` tests whose family has kSignificance [Sidak 1967].
double sidak(std::size_t count);

struct ChiSquare {
  double statistic = 0, degrees = 0, p_value = 1;
  std::string table;  // bins, expected and observed, for a failure's message
};

/// Pearson's test of counts against expected counts; bins that expect fewer than 5 are pooled.
/// A count where nothing at all is expected gives p = 0.
ChiSquare chi_square(const std::vector<double>& observed, const std::vector<double>& expected);

struct Mean {
  double mean = 0, standard_error = 0;
};
Mean mean_of(const std::vector<double>& values);

}  // namespace eikon::test
