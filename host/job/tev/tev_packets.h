// SPDX-License-Identifier: Apache-2.0
// Messages to the image viewer tev <https://github.com/Tom94/tev>, in the protocol of its
// --hostname: CreateImage and, since its version 1.15, UpdateImageV3.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "image/image.h"

namespace eikon {

struct TevImage {
  std::string name;  // by which the viewer knows it, without a byte 0
  std::uint32_t width = 0, height = 0;
  std::vector<std::string> channels;  // of EXR's form: the viewer groups them by what stands before the last dot
};

struct TevPlace {
  std::uint32_t x = 0, y = 0;  // in the image, of a picture's first pixel
};

/// A message that makes the viewer open a new image, in the place of one of the same name.
[[nodiscard]] std::string tev_create(const TevImage& image);

/// Hands `send` the messages that set all pixels and channels of `part` in the image of that name,
/// one after the other. Each has some rows, of about a megabyte.
void tev_update(const std::string& name, const Image& part, TevPlace at,
                const std::function<void(const std::string&)>& send);

}  // namespace eikon
