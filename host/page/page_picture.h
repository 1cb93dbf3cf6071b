// SPDX-License-Identifier: Apache-2.0
// Pictures in a form that a page can expose anew, and where their error is.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "io/json_text.h"

namespace eikon {

/// The longest side, in pixels, of a picture in a page. Larger ones are averaged over blocks of
/// pixels.
inline constexpr std::uint32_t kMaxPageSide = 1600;

/// Radiance as three mantissas and a power of two that they share, four bytes a pixel: a value is
/// (mantissa + 0.5) / 256 * 2^(exponent - 128), or 0 where the exponent is 0. Negative and
/// non-finite values become 0.
/// source  [Ward 1991, "Real Pixels", Graphics Gems II], with another rounding
void append_rgbe(std::vector<unsigned char>& bytes, const float (&rgb)[3]);

/// The data from which a page shows an image: its channels R, G and B, and its error if it has
/// variance.R, variance.G and variance.B:
///   "width", "height"  of the picture in the page
///   "reduced"          pixels of the image along the side of one of the picture's
///   "rgbe"             data address of a PNG of twice the height: mantissas, and below them the
///                      exponents as grey
///   "error"            data address of a grey PNG, or null where nothing is known of the variance.
///                      Grey g stands for a relative standard error of 10^(g / 51 - 4), and 0 for
///                      less: the root of the mean over R, G, B of variance / (mean^2 + 1e-2), the
///                      terms of relMSE
/// throws InputError if R, G or B is missing
[[nodiscard]] Json page_picture(const Image& image);

}  // namespace eikon
