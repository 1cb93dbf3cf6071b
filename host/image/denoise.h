// SPDX-License-Identifier: Apache-2.0
// Estimates the picture without noise by Intel's Open Image Denoise 2. The library is loaded when a
// user asks for it; eikon neither needs nor ships it. Its result is biased, so it serves for
// viewing only and no measurement uses it.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "image/image.h"

namespace eikon {

class Denoiser {
 public:
  /// Loads version 2 of the library: the file $EIKON_OIDN, else the one that the system's loader
  /// finds.
  /// throws InputError when there is none, or when it does not support this processor
  explicit Denoiser(unsigned threads);
  /// The line that says why the library cannot be loaded; empty if it can. It stays loaded.
  [[nodiscard]] static std::string problem();
  ~Denoiser();
  Denoiser(const Denoiser&) = delete;
  Denoiser& operator=(const Denoiser&) = delete;

  /// The auxiliary channels of the library, beside R, G, B; they should be as noisy as the picture
  /// or less.
  static constexpr std::array<std::string_view, 6> kAuxiliary{"albedo.R", "albedo.G", "albedo.B",
                                                              "normal.X", "normal.Y", "normal.Z"};
  /// Replaces R, G, B of a picture that has the auxiliary channels by their estimate without noise;
  /// the other channels stay.
  /// throws InputError when the library fails, InternalError when the picture lacks a channel
  void denoise(Image& picture) const;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace eikon
