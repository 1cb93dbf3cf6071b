// SPDX-License-Identifier: Apache-2.0
#include "cli/png_options.h"

#include <cmath>

#include "cli/arguments.h"
#include "image/image.h"

namespace eikon {
namespace {

/// The factor that makes the largest luminance that a camera set to EV100 can record, 1.2 * 2^EV100 cd/m^2, white; in EV.
/// source  [Lagarde, de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 5.1.2]
double exposure_of_camera(double ev100) { return -(ev100 + std::log2(1.2)); }

}  // namespace

void PngOptions::add_to(CLI::App& command) {
  command.add_option("--png", file, "also an sRGB picture; of an image with channel A an RGBA one");
  CLI::Option* const exposure = command.add_option("--exposure", exposure_ev, "of the PNG, in EV")
                                    ->check(between(-64.0, 64.0))
                                    ->capture_default_str();
  command
      .add_option(
          "--ev100", ev100,
          "EV: instead, as a camera that is set to it, of a scene in lm, lx and cd/m2; sunlight: 15, a lit room: 7")
      ->check(between(-32.0, 32.0))
      ->excludes(exposure);
  command.add_option("--tonemap", tone_map, "tone curve of the PNG, after the exposure; none: cut off at white")
      ->check(CLI::IsMember(tone_map_names()))
      ->capture_default_str();
}

void PngOptions::write(const Image& image) const {
  if (file.empty()) return;
  write_png(file, image, ev100 ? exposure_of_camera(*ev100) : exposure_ev, *tone_map_of(tone_map));
}

}  // namespace eikon
