// SPDX-License-Identifier: Apache-2.0
#include "guide/light_aim.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "guide/guide_table.h"

namespace eikon {
namespace {

constexpr float kMaxWeight = 0x1p40F, kMaxFactor = 0x1p20F;

std::size_t first_word(std::uint32_t cell) { return std::size_t{cell} * EK_GUIDE_CELL_WORDS; }

bool is_within(float x, float most) { return x >= 1 / most && x <= most; }

}  // namespace

double LightAim::density(std::uint32_t start) const {
  const std::size_t first = first_word(EK_AIM_CELL(start / EK_GUIDE_BINS / 2, start / EK_GUIDE_BINS % 2));
  const std::uint32_t bin = start % EK_GUIDE_BINS;
  const std::uint32_t weight = words[first + GUIDE_weights + bin / 2] >> (16 * (bin % 2)) & 0xffffU;
  return double(std::bit_cast<float>(words[first + AIM_weight])) * weight * (double(EK_GUIDE_BINS) / EK_GUIDE_TOTAL);
}

bool LightAim::is_sound() const {
  const std::size_t count = target_count();
  if (count == 0 || count > EK_LIGHT_TARGETS_MOST || words.size() != first_word(EK_AIM_CELL(std::uint32_t(count), 0)))
    return false;
  if (words[AIM_flags] != EK_AIM_LEARNED) return false;
  for (std::size_t first = EK_GUIDE_CELL_WORDS; first < words.size(); first += EK_GUIDE_CELL_WORDS)
    if (!is_sound_cell(std::span(words).subspan(first, EK_GUIDE_CELL_WORDS)) ||
        !is_within(std::bit_cast<float>(words[first + AIM_weight]), kMaxWeight))
      return false;
  return std::ranges::all_of(
      density_factor, [](float f) { return is_within(f, kMaxFactor) && std::exp2(std::rint(std::log2(f))) == f; });
}

LightAim make_light_aim(std::span<const AimedTarget> targets, std::array<float, kAimKinds> density_factor) {
  LightAim aim{.words = std::vector<std::uint32_t>((targets.size() + 1) * EK_GUIDE_CELL_WORDS),
               .density_factor = density_factor};
  aim.words[AIM_flags] = EK_AIM_LEARNED;
  for (std::size_t i = 0; i < targets.size(); ++i)
    std::ranges::copy(words_of({.target = targets[i].bins, .indirect = targets[i].weight}),
                      aim.words.begin() + std::ptrdiff_t((i + 1) * EK_GUIDE_CELL_WORDS));
  return aim;
}

LightAim with_named_starts(LightAim aim) {
  aim.words[AIM_flags] |= EK_AIM_NAMES_STARTS;
  return aim;
}

}  // namespace eikon
