// SPDX-License-Identifier: Apache-2.0
// The neighbours of a pixel that may have its expectation, as in the sigma filter [Lee 1983]: those
// in a window of 7x7 whose means lie within 1.5 standard deviations of its own mean.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/device_vector.h"

namespace eikon {

/// A number for each pixel of an image.
struct Plane {
  int width = 0, height = 0;
  BigVector<double> values;  // not initialised

  Plane(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] double& at(int x, int y) { return values[index(x, y)]; }
  [[nodiscard]] double at(int x, int y) const { return values[index(x, y)]; }
};

inline constexpr int kNeighbourRadius = 3;  // of the window

// Pixels that are processed together: as many as vectors of AVX2 hold. Compilers take comparisons
// of wider ones apart into single numbers there, which was six times as slow.
inline constexpr int kPixelLanes = 4;
using PixelReals = double __attribute__((vector_size(kPixelLanes * sizeof(double))));
using PixelMasks = std::int64_t __attribute__((vector_size(kPixelLanes * sizeof(double))));
// Two vectors in turns, so that the processor need not wait for the sums of one.
inline constexpr int kPixelGroups = 2;
inline constexpr int kPixelsTogether = kPixelGroups * kPixelLanes;

// Compiled for each width of vectors, of which the processor's is chosen.
#if defined(__has_feature)  // Clang
#if __has_feature(thread_sanitizer)
#define EK_THREAD_SANITIZER
#endif
#elif defined(__SANITIZE_THREAD__)  // GCC
#define EK_THREAD_SANITIZER
#endif
#ifdef EK_THREAD_SANITIZER
// The resolver that chooses a clone runs before ThreadSanitizer is ready, and would crash.
#define EK_CLONES
#else
#define EK_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#endif

/// Sums over the neighbours of a pixel that may have its expectation.
template <class Real, class Count>
struct Neighbours {
  // Sums of the differences to the pixel, of the variances, and of the squared differences.
  Real sum{}, noise{}, squares{};
  Count count{};
};

/// Sums for pixels x to x + kPixelsTogether - 1, whose windows lie within the row. Neighbours are
/// added in the order of rows. A neighbour that is left out adds zero, so sums have the same bits
/// for any width of the processor's vectors.
void find_neighbours(const Plane& mean, const Plane& variance, int x, int y,
                     std::array<Neighbours<PixelReals, PixelMasks>, kPixelGroups>& found);

/// The same sums for one pixel anywhere.
[[nodiscard]] Neighbours<double, int> neighbours_of(const Plane& mean, const Plane& variance, int x, int y);

/// Reads kPixelLanes numbers from memory.
inline __attribute__((always_inline)) void load_pixels(const Plane& plane, int x, int y, PixelReals& lanes) {
  std::memcpy(&lanes, &plane.values[plane.index(x, y)], sizeof lanes);
}

/// The number of neighbours in the window of a pixel.
[[nodiscard]] int candidates_of(const Plane& mean, int x, int y);

}  // namespace eikon
