// SPDX-License-Identifier: Apache-2.0
// The primaries of linear colours, and their way to Rec. 709.
#pragma once
#include <glm/glm.hpp>

namespace eikon {

/// CIE x, y of the primaries and of the white that equal parts of them make.
struct Chromaticities {
  glm::dvec2 red, green, blue, white;
};

inline constexpr Chromaticities kRec709{{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.3127, 0.329}};
/// X, Y and Z themselves, equal parts of which are white of equal energy.
inline constexpr Chromaticities kXyz{{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}};

/// True for Rec. 709 as far as files state it, to three digits.
[[nodiscard]] bool is_rec709(const Chromaticities& primaries);

/// Takes linear colours of these primaries to Rec. 709. Their white becomes Rec. 709's, by
/// Bradford's adaptation, so that grey stays grey.
/// throws InputError for primaries on one line, and a white that is no mixture of them
[[nodiscard]] glm::dmat3 rec709_from(const Chromaticities& primaries);

}  // namespace eikon
