// SPDX-License-Identifier: Apache-2.0
#include "gltf/animation/sampler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace eikon {
namespace {

using Numbers = std::vector<double>;

constexpr int kShareBits = 64;  // after which the ends of an arc are the same in double precision

double length_of(const Numbers& v) {
  double largest = 0;
  for (const double x : v) largest = std::max(largest, std::abs(x));
  if (!(largest > 0)) return 0;
  double sum = 0;
  for (const double x : v) sum += (x / largest) * (x / largest);
  return largest * std::sqrt(sum);
}

/// A vector along `v` of length 1, or `otherwise` if v is 0.
Numbers unit(const Numbers& v, const Numbers& otherwise) {
  const double length = length_of(v);
  if (!(length > 0)) return otherwise;
  Numbers result = v;
  for (double& x : result) x /= length;
  return result;
}

/// u + t (v - u), which is u where both are the same
Numbers lerp(const Numbers& u, const Numbers& v, double t) {
  Numbers result(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) result[i] = u[i] + t * (v[i] - u[i]);
  return result;
}

/// a u + b v
Numbers mix(double a, const Numbers& u, double b, const Numbers& v) {
  Numbers result(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) result[i] = a * u[i] + b * v[i];
  return result;
}

}  // namespace

// Halving the arc as often as the share has bits takes square roots alone, which all machines round
// alike; sines may differ in their last bit, and parts of an image that several machines render
// would not fit together.
Numbers slerp(const Numbers& from, const Numbers& to, double t) {
  double dot = 0;
  for (std::size_t i = 0; i < from.size(); ++i) dot += from[i] * to[i];
  const Numbers near_to = mix(dot < 0 ? -1 : 1, to, 0, to);  // -q is the same rotation as q
  if (t >= 1) return near_to;
  Numbers low = from, high = near_to;
  for (int bit = 0; bit < kShareBits && t > 0; ++bit) {
    const Numbers middle = unit(mix(1, low, 1, high), low);
    t *= 2;
    (t >= 1 ? low : high) = middle;
    if (t >= 1) t -= 1;
  }
  return low;
}

Numbers Curve::value(std::uint64_t key, std::uint64_t part) const {
  const std::uint64_t place = interpolation == Interpolation::cubic ? 3 * key + part : key;
  Numbers result(width);
  if (values.component_count == 1) {
    for (std::size_t i = 0; i < width; ++i) result[i] = static_cast<double>(values.vector_at(place * width + i).x);
  } else {
    const glm::vec4 v = values.vector_at(place);
    for (std::size_t i = 0; i < width; ++i) result[i] = static_cast<double>(v[static_cast<int>(i)]);
  }
  return result;
}

Numbers Curve::key_value(std::uint64_t key) const {
  Numbers result = value(key, 1);
  if (kind == ValueKind::rotation) result = unit(result, result);
  return result;
}

Numbers Curve::at(double seconds) const {
  if (!(seconds > begin_s())) return key_value(0);
  if (seconds >= end_s()) return key_value(times.count - 1);
  std::uint64_t first = 0, last = times.count;  // the first key after the time is in [first, last)
  while (first < last) {
    const std::uint64_t middle = (first + last) / 2;
    if (time_s(middle) <= seconds)
      first = middle + 1;
    else
      last = middle;
  }
  return between(first - 1, seconds);
}

Numbers Curve::between(std::uint64_t key, double seconds) const {
  const double length_s = time_s(key + 1) - time_s(key), t = (seconds - time_s(key)) / length_s;
  if (interpolation == Interpolation::step || t == 0) return key_value(key);
  if (interpolation == Interpolation::linear) {
    const Numbers from = key_value(key), to = key_value(key + 1);
    return kind == ValueKind::rotation ? slerp(from, to, t) : lerp(from, to, t);
  }
  // Tangents are per second [glTF 2.0, appendix C.5].
  const double t2 = t * t, t3 = t2 * t;
  const Numbers values_part = lerp(value(key, 1), value(key + 1, 1), 3 * t2 - 2 * t3);
  const Numbers tangents = mix(length_s * (t3 - 2 * t2 + t), value(key, 2), length_s * (t3 - t2), value(key + 1, 0));
  const Numbers result = mix(1, values_part, 1, tangents);
  return kind == ValueKind::rotation ? unit(result, key_value(key)) : result;
}

bool check_times(const Accessor& times) {
  if (!times.is(ComponentType::f32, 1)) throw InputError("its times in " + times.label + " are not SCALAR of float");
  if (times.count == 0) throw InputError("its times in " + times.label + " are none");
  if (times.data == nullptr && times.count > kMaxZeroCount)
    throw InputError(fmt::format("its times in {} are {} zeros without a bufferView", times.label, times.count));
  bool odd = times.vector_at(0).x < 0;
  float last = times.vector_at(0).x;
  for (std::uint64_t i = 0; i < times.count; ++i) {
    const float time = times.vector_at(i).x;
    if (!std::isfinite(time))
      throw InputError(fmt::format("its times in {}, element {}, are not finite", times.label, i));
    if (time < last)
      throw InputError(
          fmt::format("its times in {} fall from {:g} to {:g} s at element {}", times.label, last, time, i));
    odd = odd || (i > 0 && time == last);
    last = time;
  }
  return odd;
}

void check_value_count(const Curve& curve) {
  const Accessor& values = curve.values;
  const bool cubic = curve.interpolation == Interpolation::cubic;
  if (curve.kind == ValueKind::boolean && curve.interpolation != Interpolation::step)
    throw InputError("true and false have nothing between them: its interpolation has to be STEP");
  const std::uint64_t parts = cubic ? 3 : 1, of_value = values.component_count == 1 ? curve.width : 1;
  const std::uint64_t needed = curve.times.count * parts * of_value;
  if (values.count != needed)
    throw InputError(fmt::format("its values in {} are {}, its {} keys need {}", values.label, values.count,
                                 curve.times.count, needed));
  if (values.data == nullptr && values.count > kMaxZeroCount)
    throw InputError(fmt::format("its values in {} are {} zeros without a bufferView", values.label, values.count));
}

void check_values(const Curve& curve) {
  const Accessor& values = curve.values;
  const bool cubic = curve.interpolation == Interpolation::cubic;
  for (std::uint64_t i = 0; i < values.count; ++i) {
    const glm::vec4 v = values.vector_at(i);
    for (int c = 0; c < 4; ++c)
      if (!std::isfinite(v[c]))
        throw InputError(fmt::format("its values in {}, element {}, are not finite", values.label, i));
    const bool is_tangent = cubic && i % 3 != 1;
    if (curve.kind == ValueKind::rotation && !is_tangent && v == glm::vec4(0.0F))
      throw InputError(fmt::format("(0, 0, 0, 0) in {}, element {}, is no rotation", values.label, i));
  }
}

}  // namespace eikon
