// SPDX-License-Identifier: Apache-2.0
// The flags of the picture for eyes, beside the OpenEXR file.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "image/image.h"

namespace eikon {

struct PngOptions {
  std::string file;  // empty: none is wanted
  double exposure_ev = 0;
  std::optional<double> ev100;
  std::string tone_map = "none";

  /// Adds --png, --exposure, --ev100 and --tonemap. The object must live as long as the parser.
  void add_to(CLI::App& command);
  /// Writes the file, if one is wanted. throws as write_png
  void write(const Image& image) const;
};

}  // namespace eikon
