// SPDX-License-Identifier: Apache-2.0
#include "formula/evaluate.h"

#include <vector>

#include "formula/host_lanes.h"

namespace eikon::host_lanes {
// Included by its path, because a plain "math.h" would be the system's.
#include "lanes/interval.h"
}  // namespace eikon::host_lanes

namespace eikon::formula {
namespace {

using host_lanes::Interval;

// The operations on each kind of value: FloatOps are those of kernels, DoubleOps the host's own,
// IntervalOps those of kernels on intervals.

template <class T>
struct Arithmetic {
  static T constant(const Node& node) { return T(node.value()); }
  static T add(T a, T b) { return a + b; }
  static T sub(T a, T b) { return a - b; }
  static T mul(T a, T b) { return a * b; }
  static T div(T a, T b) { return a / b; }
  static T neg(T a) { return -a; }
  static T sqrt(T a) { return std::sqrt(a); }
  static T choose(T a, T b, T below, T rest) { return a < b ? below : rest; }
};

struct FloatOps : Arithmetic<float> {
  static float power(float a, std::uint32_t n) { return host_lanes::formula_power(a, n); }
  static float abs(float a) { return host_lanes::abs_f(a); }
  static float min(float a, float b) { return host_lanes::min_f(a, b); }
  static float max(float a, float b) { return host_lanes::max_f(a, b); }
  static float sin(float a) { return host_lanes::formula_sin(a); }
  static float cos(float a) { return host_lanes::formula_cos(a); }
  static float exp(float a) { return host_lanes::formula_exp(a); }
  static float log(float a) { return host_lanes::formula_log(a); }
  static float atan(float a) { return host_lanes::formula_atan(a); }
};

struct DoubleOps : Arithmetic<double> {
  static double power(double a, std::uint32_t n) { return std::pow(a, double(n)); }
  static double abs(double a) { return std::abs(a); }
  static double min(double a, double b) { return a < b ? a : b; }
  static double max(double a, double b) { return a > b ? a : b; }
  static double sin(double a) { return std::sin(a); }
  static double cos(double a) { return std::cos(a); }
  static double exp(double a) { return std::exp(a); }
  static double log(double a) { return std::log(a); }
  static double atan(double a) { return std::atan(a); }
};

struct IntervalOps {
  bool undefined = false;  // some operation had no value anywhere
  static Interval constant(const Node& node) { return host_lanes::interval_point(node.value()); }
  static Interval add(Interval a, Interval b) { return host_lanes::interval_add(a, b); }
  static Interval sub(Interval a, Interval b) { return host_lanes::interval_sub(a, b); }
  static Interval mul(Interval a, Interval b) { return host_lanes::interval_mul(a, b); }
  static Interval div(Interval a, Interval b) { return host_lanes::interval_div(a, b); }
  static Interval neg(Interval a) { return host_lanes::interval_neg(a); }
  static Interval power(Interval a, std::uint32_t n) { return host_lanes::interval_power(a, n); }
  Interval sqrt(Interval a) {
    undefined |= host_lanes::interval_sqrt_undefined(a) != 0;
    return host_lanes::interval_sqrt(a);
  }
  static Interval abs(Interval a) { return host_lanes::interval_abs(a); }
  static Interval min(Interval a, Interval b) { return host_lanes::interval_min(a, b); }
  static Interval max(Interval a, Interval b) { return host_lanes::interval_max(a, b); }
  static Interval sin(Interval a) { return host_lanes::interval_sin(a); }
  static Interval cos(Interval a) { return host_lanes::interval_cos(a); }
  static Interval exp(Interval a) { return host_lanes::interval_exp(a); }
  Interval log(Interval a) {
    undefined |= host_lanes::interval_log_undefined(a) != 0;
    return host_lanes::interval_log(a);
  }
  static Interval atan(Interval a) { return host_lanes::interval_atan(a); }
  static Interval choose(Interval a, Interval b, Interval below, Interval rest) {
    return host_lanes::interval_choose(a, b, below, rest);
  }
};

template <class Ops, class Value>
Value apply_op(Ops& ops, const Node& node, const std::array<Value, 4>& v) {
  switch (node.op) {
    case Op::constant:
      return ops.constant(node);
    case Op::variable:
      return v[0];
    case Op::add:
      return ops.add(v[0], v[1]);
    case Op::sub:
      return ops.sub(v[0], v[1]);
    case Op::mul:
      return ops.mul(v[0], v[1]);
    case Op::div:
      return ops.div(v[0], v[1]);
    case Op::neg:
      return ops.neg(v[0]);
    case Op::power:
      return ops.power(v[0], node.number);
    case Op::sqrt:
      return ops.sqrt(v[0]);
    case Op::abs:
      return ops.abs(v[0]);
    case Op::min:
      return ops.min(v[0], v[1]);
    case Op::max:
      return ops.max(v[0], v[1]);
    case Op::sin:
      return ops.sin(v[0]);
    case Op::cos:
      return ops.cos(v[0]);
    case Op::exp:
      return ops.exp(v[0]);
    case Op::log:
      return ops.log(v[0]);
    case Op::atan:
      return ops.atan(v[0]);
    case Op::choose:
      return ops.choose(v[0], v[1], v[2], v[3]);
  }
  return v[0];
}

// Computes the nodes up to `root` in order: `at` gives the value of a variable, `apply` that of a
// node.
template <class Value, class At, class Apply>
Value walk(const Expressions& expressions, Id root, const At& at, const Apply& apply) {
  const std::vector<bool> need = needed(expressions, {root});
  std::vector<Value> values(root + 1);
  for (Id id = 0; id <= root; ++id) {
    if (!need[id]) continue;
    const Node& node = expressions[id];
    std::array<Value, 4> operands{};
    if (node.op == Op::variable) operands[0] = at(node.number);
    for (std::size_t i = 0; i < operand_count(node.op); ++i) operands[i] = values[node.operands[i]];
    values[id] = apply(node, operands);
  }
  return values[root];
}

}  // namespace

float apply_op(const Node& node, const std::array<float, 4>& values) {
  FloatOps ops;
  return apply_op(ops, node, values);
}

float evaluate(const Expressions& expressions, Id root, const Point& point) {
  return walk<float>(
      expressions, root, [&](std::uint32_t i) { return point[i]; },
      [](const Node& node, const std::array<float, 4>& v) { return apply_op(node, v); });
}

RegionValue evaluate(const Expressions& expressions, Id root, const Region& region) {
  IntervalOps ops;
  const Interval value = walk<Interval>(
      expressions, root, [&](std::uint32_t i) { return host_lanes::interval(region[i].lo, region[i].hi); },
      [&](const Node& node, const std::array<Interval, 4>& v) {
        if (is_scaling(expressions, node)) return host_lanes::interval_scale(v[0].lo, v[1]);
        return apply_op(ops, node, v);
      });
  return {.bounds = {.lo = value.lo, .hi = value.hi}, .undefined = ops.undefined};
}

double evaluate_double(const Expressions& expressions, Id root, const std::array<double, kVariables>& point) {
  DoubleOps ops;
  return walk<double>(
      expressions, root, [&](std::uint32_t i) { return point[i]; },
      [&](const Node& node, const std::array<double, 4>& v) { return apply_op(ops, node, v); });
}

}  // namespace eikon::formula
