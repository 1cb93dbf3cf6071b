// SPDX-License-Identifier: Apache-2.0
// A trial learns which targets of light paths, and which parts of their cones and discs, lead to
// light that the camera sees. These are the tables of that (kernels/lights/light_aim.h).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/light_target.h"

namespace eikon {

inline constexpr std::size_t kAimKinds = 2;  // EK_AIM_CONE and EK_AIM_DISC

/// One target of light paths, for one way to start.
struct AimedTarget {
  double weight = 1;                         // among all targets, over that of one that nothing is known of
  std::array<double, EK_GUIDE_BINS> bins{};  // not normalised; all 0: no preference
};

struct LightAim {
  std::vector<std::uint32_t> words = {0};  // of buffer light_aim; these: starts are even
  /// For each kind of start, the density of those that bring light over that of even ones, in the
  /// mean and to a power of two. Camera paths and light paths share light by it.
  std::array<float, kAimKinds> density_factor = {1, 1};

  [[nodiscard]] bool is_learned() const { return (words.front() & EK_AIM_LEARNED) != 0; }
  [[nodiscard]] std::size_t target_count() const { return words.size() / EK_GUIDE_CELL_WORDS / kAimKinds; }
  /// The density of a start of this name (EK_AIM_START) over that of an even one, if no other
  /// target lies in its direction.
  [[nodiscard]] double density(std::uint32_t start) const;
  /// True if kernels may look things up in it: weights are those of densities, and factors are
  /// powers of two.
  [[nodiscard]] bool is_sound() const;
};

/// targets  of the cones and of the discs in turn: [kAimKinds * target + kind]; weights are rounded
///          to floats
[[nodiscard]] LightAim make_light_aim(std::span<const AimedTarget> targets,
                                      std::array<float, kAimKinds> density_factor);
/// The same aim of a render whose splats name the starts of their light paths.
[[nodiscard]] LightAim with_named_starts(LightAim aim);

}  // namespace eikon
