// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/aim_learner.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace eikon {
namespace {

constexpr std::size_t kRows = EK_GUIDE_ROWS;
constexpr double kMinWeight = 0.25;  // of a target over the mean: it may lead to light that the trial has not met

/// Squares of a target's bins, each with its neighbours', as the trial has met few starts of each.
std::array<double, EK_GUIDE_BINS> blurred(std::span<const double> squares) {
  std::array<double, EK_GUIDE_BINS> result{};
  for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) {
    const auto row = int(bin / kRows), column = int(bin % kRows);
    double sum = 0, weights = 0;
    for (int j = std::max(row - 1, 0); j <= std::min(row + 1, int(kRows) - 1); ++j)
      for (int i = std::max(column - 1, 0); i <= std::min(column + 1, int(kRows) - 1); ++i) {
        const double weight = (j == row ? 2.0 : 1.0) * (i == column ? 2.0 : 1.0);
        sum += weight * squares[std::size_t(j) * kRows + std::size_t(i)];
        weights += weight;
      }
    result[bin] = sum / weights;
  }
  return result;
}

float power_of_two_near(double x) { return float(std::exp2(std::clamp(std::rint(std::log2(x)), -20.0, 20.0))); }

}  // namespace

AimLearner::AimLearner(std::span<const double> shares, std::shared_ptr<const LightAim> aim)
    : shares_(shares), aim_(std::move(aim)) {
  for (Squares& squares : squares_) squares.resize(shares.size() * EK_GUIDE_BINS);
}

void AimLearner::add(std::uint32_t half, std::uint32_t start, double square) {
  Squares& squares = squares_[half & 1U];
  if (start >= squares.size()) return;
  const double density = aim_ == nullptr ? 1 : aim_->density(start);
  squares[start] += square * density * density;
}

void AimLearner::add(const AimLearner& aimed) {
  // Squares of one start, in the mean over the starts of both trials.
  for (std::size_t half = 0; half < squares_.size(); ++half)
    for (std::size_t start = 0; start < squares_[half].size(); ++start)
      squares_[half][start] =
          (squares_[half][start] + aimed.squares_[half][start]) / (1 + aimed.aim_->density(std::uint32_t(start)));
}

LightAim AimLearner::learned_from(const Squares& squares) const {
  std::vector<AimedTarget> targets(shares_.size());
  std::array<double, kAimKinds> all_shares{}, all_roots{};
  std::vector<double> roots(shares_.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    targets[i].bins = blurred(std::span(squares).subspan(i * EK_GUIDE_BINS, EK_GUIDE_BINS));
    for (double& bin : targets[i].bins) roots[i] += bin = std::sqrt(bin);
    roots[i] *= std::sqrt(shares_[i]);
    all_shares[i % kAimKinds] += shares_[i];
    all_roots[i % kAimKinds] += roots[i];
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const double sum = all_roots[i % kAimKinds];
    if (!(sum > 0) || !(shares_[i] > 0)) continue;
    const double weight = roots[i] / sum * all_shares[i % kAimKinds] / shares_[i];
    targets[i].weight = kMinWeight + (1 - kMinWeight) * weight;
  }
  LightAim aim = make_light_aim(targets, {1, 1});
  std::array<double, kAimKinds> plain{}, denser{};
  for (std::size_t start = 0; start < squares.size(); ++start) {
    const std::size_t kind = start / EK_GUIDE_BINS % kAimKinds;
    const double amount = std::sqrt(squares[start] * shares_[start / EK_GUIDE_BINS]);
    plain[kind] += amount;
    denser[kind] += amount * aim.density(std::uint32_t(start));
  }
  for (std::size_t kind = 0; kind < kAimKinds; ++kind)
    if (plain[kind] > 0) aim.density_factor[kind] = power_of_two_near(denser[kind] / plain[kind]);
  return aim;
}

double AimLearner::gain() const {
  double even = 0, aimed = 0;
  for (std::size_t half = 0; half < squares_.size(); ++half) {
    const LightAim aim = learned_from(squares_[half]);
    const Squares& other = squares_[1 - half];
    for (std::size_t start = 0; start < other.size(); ++start) {
      if (other[start] == 0) continue;
      even += other[start];
      aimed += other[start] / aim.density(std::uint32_t(start));
    }
  }
  return aimed > 0 ? even / aimed : 1;
}

LightAim AimLearner::result() const {
  Squares both = squares_[0];
  for (std::size_t start = 0; start < both.size(); ++start) both[start] += squares_[1][start];
  return learned_from(both);
}

}  // namespace eikon
