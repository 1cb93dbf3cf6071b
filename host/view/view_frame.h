// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "film/film.h"
#include "image/image.h"
#include "view/view_look.h"

namespace eikon {

/// A picture for a page: four bytes a pixel as append_rgbe() makes them (page/page_picture.h), of
/// the layer of the look:
///   picture   radiance
///   denoised  the noisy radiance, as `picture`; ViewDenoiser replaces it later
///   lights    the sum of the light groups' radiance, each times its factor
///   albedo    albedo
///   normal    (n + 1) / 2, world space; 0.5 in all three where the camera sees nothing
///   depth     metres in all three; 0 where the camera sees nothing
///   error     the relative standard error of the pixel in all three; 0 where it is not known
/// throws InternalError if the film lacks the layer
[[nodiscard]] std::vector<unsigned char> view_pixels(const Film& film, const ViewLook& look);
/// The same of R, G and B.
[[nodiscard]] std::vector<unsigned char> view_pixels(const Image& picture);

}  // namespace eikon
