// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <variant>
#include <vector>

#include "scene/shared_vector.h"

namespace eikon {

/// The ways in which corners form triangles; the values are those of glTF's "mode".
enum class TriangleMode { list = 4, strip = 5, fan = 6 };

/// The corners of triangles, as indices of vertices. They take no more memory than a file does for
/// them: indices have the bytes that the largest one needs, a strip or a fan stays one, and copies
/// share them.
class TriangleIndices {
 public:
  TriangleIndices() = default;
  TriangleIndices(std::vector<std::uint32_t> list) : corners_(Words(std::move(list))) {}
  TriangleIndices(std::initializer_list<std::uint32_t> list) : TriangleIndices(std::vector<std::uint32_t>(list)) {}

  /// Corners in the order of a file: `count` of them, each at most `largest`. They make triangles
  /// as in [glTF 2.0, section 3.7.2.1], by which every other triangle of a strip turns. Triangles
  /// of strips and fans with a corner twice only lead on to the next one and are dropped; those of
  /// lists stay. Corners beyond the last whole triangle are dropped.
  struct Source {
    TriangleMode mode = TriangleMode::list;
    std::size_t count = 0;
    std::uint32_t largest = 0;
    std::function<std::uint32_t(std::size_t)> corner;
  };
  explicit TriangleIndices(const Source& source);

  /// Three for each triangle.
  [[nodiscard]] std::size_t size() const { return 3 * triangle_count(); }
  [[nodiscard]] bool empty() const { return triangle_count() == 0; }
  [[nodiscard]] std::size_t triangle_count() const;
  [[nodiscard]] std::array<std::uint32_t, 3> triangle(std::size_t t) const;
  [[nodiscard]] std::uint32_t operator[](std::size_t i) const { return triangle(i / 3)[i % 3]; }
  [[nodiscard]] std::vector<std::uint32_t> list() const;
  /// Bytes of memory, which copies share.
  [[nodiscard]] std::size_t bytes() const;

  void push_back(std::uint32_t index);  // to a list
  /// Replaces each index i by number[i]. No number may be larger than the largest index was.
  void renumber(const std::vector<std::uint32_t>& number);

  friend bool operator==(const TriangleIndices& a, const TriangleIndices& b) { return a.list() == b.list(); }

 private:
  using Words = SharedVector<std::uint32_t>;

  [[nodiscard]] std::uint32_t corner(std::size_t i) const {
    if (const auto* bytes = std::get_if<SharedVector<std::uint8_t>>(&corners_)) return (*bytes)[i];
    if (const auto* halves = std::get_if<SharedVector<std::uint16_t>>(&corners_)) return (*halves)[i];
    return (*std::get_if<Words>(&corners_))[i];
  }
  [[nodiscard]] std::size_t corner_count() const;
  /// The triangle that begins at corner `at` of a strip or fan.
  [[nodiscard]] std::array<std::uint32_t, 3> triangle_at(std::size_t at) const;

  TriangleMode mode_ = TriangleMode::list;
  std::variant<Words, SharedVector<std::uint16_t>, SharedVector<std::uint8_t>> corners_;
  Words dropped_;  // triangles of a strip or fan that are none, ascending
};

}  // namespace eikon
