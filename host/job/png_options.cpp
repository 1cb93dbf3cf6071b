// SPDX-License-Identifier: Apache-2.0
#include "job/png_options.h"

#include <cmath>

namespace eikon {
namespace {

/// The exposure in EV that maps 1.2 * 2^EV100 cd/m^2 to white: the largest luminance that a camera
/// set to EV100 can record.
/// source  [Lagarde, de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", 5.1.2]
double exposure_of_camera(double ev100) { return -(ev100 + std::log2(1.2)); }

}  // namespace

void PngOptions::write(const Image& image) const {
  if (file.empty()) return;
  write_png(file, image, ev100 ? exposure_of_camera(*ev100) : exposure_ev, tone_map);
}

}  // namespace eikon
