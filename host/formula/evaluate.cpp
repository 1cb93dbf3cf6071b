// SPDX-License-Identifier: Apache-2.0
#include "formula/evaluate.h"

#include <vector>

#include "formula/host_lanes.h"

namespace eikon::host_lanes {
// By path: a plain "math.h" would be the system's.
#include "../../kernels/interval.h"
}  // namespace eikon::host_lanes

namespace eikon::formula {
namespace {

using host_lanes::Interval;

Interval apply_op(const Node& node, const std::array<Interval, 4>& v, bool* undefined) {
  using namespace host_lanes;
  switch (node.op) {
    case Op::constant:
      return interval_point(node.value());
    case Op::variable:
      return v[0];
    case Op::add:
      return interval_add(v[0], v[1]);
    case Op::sub:
      return interval_sub(v[0], v[1]);
    case Op::mul:
      return interval_mul(v[0], v[1]);
    case Op::div:
      return interval_div(v[0], v[1]);
    case Op::neg:
      return interval_neg(v[0]);
    case Op::power:
      return interval_power(v[0], node.number);
    case Op::sqrt:
      *undefined |= interval_sqrt_undefined(v[0]) != 0;
      return interval_sqrt(v[0]);
    case Op::abs:
      return interval_abs(v[0]);
    case Op::min:
      return interval_min(v[0], v[1]);
    case Op::max:
      return interval_max(v[0], v[1]);
    case Op::sin:
      return interval_sin(v[0]);
    case Op::cos:
      return interval_cos(v[0]);
    case Op::exp:
      return interval_exp(v[0]);
    case Op::log:
      *undefined |= interval_log_undefined(v[0]) != 0;
      return interval_log(v[0]);
    case Op::atan:
      return interval_atan(v[0]);
    case Op::choose:
      return interval_choose(v[0], v[1], v[2], v[3]);
  }
  return interval_whole();
}

double apply_op(const Node& node, const std::array<double, 4>& v) {
  switch (node.op) {
    case Op::constant:
      return double(node.value());
    case Op::variable:
      return v[0];
    case Op::add:
      return v[0] + v[1];
    case Op::sub:
      return v[0] - v[1];
    case Op::mul:
      return v[0] * v[1];
    case Op::div:
      return v[0] / v[1];
    case Op::neg:
      return -v[0];
    case Op::power:
      return std::pow(v[0], double(node.number));
    case Op::sqrt:
      return std::sqrt(v[0]);
    case Op::abs:
      return std::abs(v[0]);
    case Op::min:
      return v[0] < v[1] ? v[0] : v[1];
    case Op::max:
      return v[0] > v[1] ? v[0] : v[1];
    case Op::sin:
      return std::sin(v[0]);
    case Op::cos:
      return std::cos(v[0]);
    case Op::exp:
      return std::exp(v[0]);
    case Op::log:
      return std::log(v[0]);
    case Op::atan:
      return std::atan(v[0]);
    case Op::choose:
      return v[0] < v[1] ? v[2] : v[3];
  }
  return 0;
}

// The nodes up to `root` in order; `at` says what a variable is, `apply` what a node is.
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

float apply_op(const Node& node, const std::array<float, 4>& v) {
  using namespace host_lanes;
  switch (node.op) {
    case Op::constant:
      return node.value();
    case Op::variable:
      return v[0];
    case Op::add:
      return v[0] + v[1];
    case Op::sub:
      return v[0] - v[1];
    case Op::mul:
      return v[0] * v[1];
    case Op::div:
      return v[0] / v[1];
    case Op::neg:
      return -v[0];
    case Op::power:
      return formula_power(v[0], node.number);
    case Op::sqrt:
      return std::sqrt(v[0]);
    case Op::abs:
      return abs_f(v[0]);
    case Op::min:
      return min_f(v[0], v[1]);
    case Op::max:
      return max_f(v[0], v[1]);
    case Op::sin:
      return formula_sin(v[0]);
    case Op::cos:
      return formula_cos(v[0]);
    case Op::exp:
      return formula_exp(v[0]);
    case Op::log:
      return formula_log(v[0]);
    case Op::atan:
      return formula_atan(v[0]);
    case Op::choose:
      return v[0] < v[1] ? v[2] : v[3];
  }
  return 0;
}

float evaluate(const Expressions& expressions, Id root, const Point& point) {
  return walk<float>(
      expressions, root, [&](std::uint32_t i) { return point[i]; },
      [](const Node& node, const std::array<float, 4>& v) { return apply_op(node, v); });
}

RegionValue evaluate(const Expressions& expressions, Id root, const Region& region) {
  bool undefined = false;
  const Interval value = walk<Interval>(
      expressions, root, [&](std::uint32_t i) { return host_lanes::interval(region[i].lo, region[i].hi); },
      [&](const Node& node, const std::array<Interval, 4>& v) {
        if (is_scaling(expressions, node)) return host_lanes::interval_scale(v[0].lo, v[1]);
        return apply_op(node, v, &undefined);
      });
  return {.bounds = {.lo = value.lo, .hi = value.hi}, .undefined = undefined};
}

double evaluate_double(const Expressions& expressions, Id root, const std::array<double, kVariables>& point) {
  return walk<double>(
      expressions, root, [&](std::uint32_t i) { return point[i]; },
      [](const Node& node, const std::array<double, 4>& v) { return apply_op(node, v); });
}

}  // namespace eikon::formula
