// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "image/image.h"

namespace eikon {

/// Takes the noise out of pictures, on a thread of its own, by the library that image/denoise.h
/// loads.
class ViewDenoiser {
 public:
  /// Gets the picture without noise.
  using Done = std::function<void(const Image&)>;
  /// Is told, on the thread, why there is no such picture.
  using Problem = std::function<void(const std::string&)>;

  /// threads  that the library may use; 0: all
  ViewDenoiser(unsigned threads, Problem problem);
  /// Does not wait for a picture that is under way: its thread is lost then (core/lost_threads.h).
  ~ViewDenoiser();
  ViewDenoiser(const ViewDenoiser&) = delete;
  ViewDenoiser& operator=(const ViewDenoiser&) = delete;

  /// True if another picture of as many samples would be worth its time: none is under way, this
  /// one has half as many samples again as the one before, and the last one took at most a fifth of
  /// the time since it began.
  [[nodiscard]] bool pays(std::uint64_t samples) const;
  /// Begins with a picture (Denoiser::kAuxiliary) once the one that is under way is ready; one that
  /// waits for this is dropped.
  void begin(Image picture, std::uint64_t samples, Done done);
  /// Nothing comes of the pictures before this call any more.
  void forget();

 private:
  struct Work;
  std::shared_ptr<Work> work_;
  std::thread thread_;
};

}  // namespace eikon
