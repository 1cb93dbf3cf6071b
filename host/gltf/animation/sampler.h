// SPDX-License-Identifier: Apache-2.0
// A value over time by the keys of an animation's sampler [glTF 2.0, section 3.11 and appendix C].
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gltf/document/accessor_table.h"

namespace eikon {

enum class Interpolation : std::uint8_t { step, linear, cubic };

/// How values between two keys are made.
enum class ValueKind : std::uint8_t {
  numbers,   // each number for itself
  rotation,  // a quaternion (x, y, z, w): along the shortest arc, and of length 1
  boolean    // true or false, which only steps
};

/// Keys of values of `width` numbers each. check_curve has let it pass.
struct Curve {
  const Accessor& times;   // seconds, which do not fall
  const Accessor& values;  // a vector for each key, or `width` scalars; three of them with `cubic`
  Interpolation interpolation = Interpolation::linear;
  ValueKind kind = ValueKind::numbers;
  std::size_t width = 1;

  [[nodiscard]] double begin_s() const { return time_s(0); }
  [[nodiscard]] double end_s() const { return time_s(times.count - 1); }
  /// The value at a time: that of the first key before it, that of the last key after it. `width`
  /// numbers; a rotation has length 1.
  [[nodiscard]] std::vector<double> at(double seconds) const;

 private:
  [[nodiscard]] double time_s(std::uint64_t key) const { return static_cast<double>(times.vector_at(key).x); }
  /// part  0: the value, or with `cubic` the tangent towards it; 1 and 2: value, and tangent from
  ///       it
  [[nodiscard]] std::vector<double> value(std::uint64_t key, std::uint64_t part) const;
  [[nodiscard]] std::vector<double> key_value(std::uint64_t key) const;
  [[nodiscard]] std::vector<double> between(std::uint64_t key, double seconds) const;
};

/// Checks the times of keys. Returns whether some of them are negative or equal, which the format
/// forbids and which nonetheless have a meaning.
/// throws InputError, without the sampler: a type that is not SCALAR of float, no key, times that
/// fall or are
///        not finite
bool check_times(const Accessor& times);

/// throws InputError, without the sampler: another number of values than the keys need, a boolean
/// that does not step
void check_value_count(const Curve& curve);

/// Looks at each value. throws InputError, without the sampler: one that is not finite, a rotation
/// of length 0
void check_values(const Curve& curve);

/// The rotation a share `t` in [0, 1] of the way from one unit quaternion to another, by the
/// shorter way at constant speed. The same bits on every machine.
[[nodiscard]] std::vector<double> slerp(const std::vector<double>& from, const std::vector<double>& to, double t);

}  // namespace eikon
