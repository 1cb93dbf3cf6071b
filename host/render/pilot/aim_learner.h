// SPDX-License-Identifier: Apache-2.0
// Learns from the splats of a trial where light paths should start (guide/light_aim.h).
//
// The splats of a trial whose light paths start evenly give, by their squares, the second moment of
// what light paths bring. Each bin of starts has a part of it. If starts in a bin become s times as
// dense, its part is divided by s. The sum over all bins is least if the density of each bin is
// proportional to the square root of its part [Kahn and Marshall 1953].
//
// What is learned from few splats suits these splats better than others. So gain() learns from each
// half of the trial, and measures with the splats of the other half.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "guide/light_aim.h"

namespace eikon {

class AimLearner {
 public:
  /// shares  PackedScene::light_target_shares
  /// aim     by which the trial's light paths start; null: they start evenly
  AimLearner(std::span<const double> shares, std::shared_ptr<const LightAim> aim);

  /// Adds a splat. The order of these matters for the last bits of sums.
  /// half    0 or 1: samples of the trial that it belongs to
  /// start   EK_AIM_START
  /// square  what it adds to the relative error of its pixel
  void add(std::uint32_t half, std::uint32_t start, double square);

  /// Adds what another trial of the same picture has found, with other starts: this one's are even.
  void add(const AimLearner& aimed);

  /// Second moment with even starts over that with learned ones: of each half, by what the other
  /// half teaches.
  [[nodiscard]] double gain() const;
  /// Learns from both halves.
  [[nodiscard]] LightAim result() const;

 private:
  using Squares = std::vector<double>;  // by start, as if these were even

  [[nodiscard]] LightAim learned_from(const Squares& squares) const;

  std::span<const double> shares_;
  std::shared_ptr<const LightAim> aim_;
  std::array<Squares, 2> squares_;
};

}  // namespace eikon
