// SPDX-License-Identifier: Apache-2.0
// A guess at the picture without noise, by Intel's Open Image Denoise, which is loaded when it is asked for: eikon neither needs
// it nor ships it. For eyes only: what it adds is not unbiased, so no measurement uses it.
#pragma once
#include <memory>

#include "image/image.h"
#include "film/film.h"

namespace eikon {

class Denoiser {
 public:
  /// Loads version 2 of the library: the file $EIKON_OIDN, else what the system's loader finds.
  /// throws InputError when there is none, or it does not support this processor
  explicit Denoiser(unsigned threads);
  ~Denoiser();
  Denoiser(const Denoiser&) = delete;
  Denoiser& operator=(const Denoiser&) = delete;

  /// R, G, B of the film (and its A as it is), guided by its layers albedo and normal.
  /// throws InputError when the library fails, InternalError when the film lacks the layers
  [[nodiscard]] Image denoise(const Film& film) const;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace eikon
