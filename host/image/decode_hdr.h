// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace eikon {

struct HdrImage {
  std::uint32_t width = 0, height = 0;
  std::vector<glm::vec3> rgb;  // row-major from the top, linear; finite and >= 0
};

/// Decodes a Radiance picture (RGBE): flat, old and new run-length coding, rows first in either
/// direction. EXPOSURE and COLORCORR are divided out; the primaries are taken as Rec. 709. The
/// claims of the header are checked before anything is allocated: at most 65536 pixels a side,
/// `max_bytes` for `rgb`, and a size that is credible for so many bytes of file.
/// throws InputError (without the file's name): not Radiance, XYZE, columns first, too large,
/// truncated, damaged
/// source Ward, "Real Pixels", Graphics Gems II, 1991; Radiance's own src/common/color.c
HdrImage decode_hdr(std::span<const std::byte> bytes, std::uint64_t max_bytes);

}  // namespace eikon
