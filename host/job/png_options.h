// SPDX-License-Identifier: Apache-2.0
// The 8-bit picture beside the OpenEXR file.
#pragma once
#include <optional>
#include <string>

#include "image/image.h"

namespace eikon {

struct PngOptions {
  std::string file;  // empty: none is wanted
  double exposure_ev = 0;
  std::optional<double> ev100;  // instead of exposure_ev: of a camera set to it
  ToneMap tone_map{};

  /// Writes the file, if one is wanted. throws as write_png
  void write(const Image& image) const;
};

}  // namespace eikon
