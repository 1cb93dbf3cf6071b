// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "image/primaries.h"

namespace eikon {

/// A picture of light in linear colours.
struct HdrImage {
  std::uint32_t width = 0, height = 0;
  std::vector<glm::vec3> rgb;                 // row-major from the top; of Radiance finite and >= 0
  std::optional<Chromaticities> primaries{};  // what the file states; nothing: Rec. 709
  bool is_cube = false;                       // OpenEXR's attribute envmap: six faces below each other
};

/// Decodes a Radiance picture (RGBE or XYZE): flat, old and new run-length coding, rows first in
/// either direction. EXPOSURE and COLORCORR are divided out, and from XYZE its 179 lumens per watt.
/// The claims of the header are checked before anything is allocated: at most 65536 pixels a side,
/// `max_bytes` for `rgb`, and a size that is credible for so many bytes of file.
/// throws InputError (without the file's name): not Radiance, columns first, too large, truncated,
/// damaged
/// source Ward, "Real Pixels", Graphics Gems II, 1991; Radiance's own src/common/color.c
HdrImage decode_hdr(std::span<const std::byte> bytes, std::uint64_t max_bytes);

/// Reads R, G and B, or Y for all three, of part 0 of an OpenEXR file, and no other channel. Sizes
/// are checked as by read_exr(), with `max_bytes` for `rgb`. throws InputError
HdrImage read_exr_rgb(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace eikon
