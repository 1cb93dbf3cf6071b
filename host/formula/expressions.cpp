// SPDX-License-Identifier: Apache-2.0
#include "formula/expressions.h"

#include <fmt/format.h>

#include <bit>
#include <utility>

#include "core/error.h"
#include "formula/evaluate.h"

namespace eikon::formula {

float Node::value() const { return std::bit_cast<float>(number); }

const OpInfo& info_of(Op op) {
  static constexpr OpInfo kOps[] = {
      // In the order of Op. The code of constants and variables is not made of operands.
      {0, "", ""},
      {0, "", ""},
      {2, "{0} + {1}", "interval_add({0}, {1})"},
      {2, "{0} - {1}", "interval_sub({0}, {1})"},
      {2, "{0} * {1}", "interval_mul({0}, {1})"},
      {2, "div_f({0}, {1})", "interval_div({0}, {1})"},
      {1, "-{0}", "interval_neg({0})"},
      {1, "formula_power({0}, {4}u)", "interval_power({0}, {4}u)"},
      {1, "sqrt_f({0})", "interval_sqrt({0})"},
      {1, "abs_f({0})", "interval_abs({0})"},
      {2, "min_f({0}, {1})", "interval_min({0}, {1})"},
      {2, "max_f({0}, {1})", "interval_max({0}, {1})"},
      {1, "formula_sin({0})", "interval_sin({0})"},
      {1, "formula_cos({0})", "interval_cos({0})"},
      {1, "formula_exp({0})", "interval_exp({0})"},
      {1, "formula_log({0})", "interval_log({0})"},
      {1, "formula_atan({0})", "interval_atan({0})"},
      {4, "{0} < {1} ? {2} : {3}", "interval_choose({0}, {1}, {2}, {3})"},
  };
  static_assert(std::size(kOps) == std::size_t(Op::choose) + 1);
  return kOps[std::size_t(op)];
}

bool Expressions::is_constant(Id id, float value) const { return is_constant(id) && nodes_[id].value() == value; }

Id Expressions::node(Op op, std::uint32_t number, std::array<Id, 4> operands) {
  const Node made{.op = op, .number = number, .operands = operands};
  const std::size_t count = operand_count(op);
  bool constant = count > 0;
  for (std::size_t i = 0; i < count; ++i) constant = constant && is_constant(operands[i]);
  if (constant) return folded(made);
  const auto found = known_.find(made);
  if (found != known_.end()) return found->second;
  if (nodes_.size() == kMaxNodes)
    throw InputError(fmt::format("too complex: it and its derivatives take more than {} operations", kMaxNodes));
  nodes_.push_back(made);
  const Id id = Id(nodes_.size() - 1);
  known_.emplace(made, id);
  return id;
}

Id Expressions::folded(const Node& node) {
  std::array<float, 4> values{};
  for (std::size_t i = 0; i < operand_count(node.op); ++i) values[i] = nodes_[node.operands[i]].value();
  return constant(apply_op(node, values));
}

Id Expressions::constant(float value) {
  return node(Op::constant, std::bit_cast<std::uint32_t>(value == 0.0F ? 0.0F : value), {});
}

Id Expressions::variable(Variable which) { return node(Op::variable, std::uint32_t(which), {}); }

Id Expressions::neg(Id a) {
  if (nodes_[a].op == Op::neg) return nodes_[a].operands[0];
  if (nodes_[a].op == Op::sub) return sub(nodes_[a].operands[1], nodes_[a].operands[0]);
  return node(Op::neg, 0, {a});
}

Id Expressions::add(Id a, Id b) {
  if (a > b) std::swap(a, b);  // a sum has the same bits either way, and is found again in one order
  if (is_constant(a, 0)) return b;
  if (is_constant(b, 0)) return a;
  if (a == b) return mul(constant(2), a);
  if (nodes_[b].op == Op::neg) return sub(a, nodes_[b].operands[0]);
  if (nodes_[a].op == Op::neg) return sub(b, nodes_[a].operands[0]);
  return node(Op::add, 0, {a, b});
}

Id Expressions::sub(Id a, Id b) {
  if (is_constant(b, 0)) return a;
  if (is_constant(a, 0)) return neg(b);
  if (nodes_[b].op == Op::neg) return add(a, nodes_[b].operands[0]);
  return node(Op::sub, 0, {a, b});
}

Id Expressions::mul(Id a, Id b) {
  if (a > b) std::swap(a, b);
  if (is_constant(b)) std::swap(a, b);  // a constant comes first
  if (is_constant(a, 0) || is_constant(b, 1)) return a;
  if (is_constant(a, 1)) return b;
  if (is_constant(a, -1)) return neg(b);
  if (a == b) return power(a, 2);
  if (nodes_[a].op == Op::neg && nodes_[b].op == Op::neg) return mul(nodes_[a].operands[0], nodes_[b].operands[0]);
  if (nodes_[b].op == Op::neg && !is_constant(a)) return neg(mul(a, nodes_[b].operands[0]));
  if (nodes_[a].op == Op::neg) return neg(mul(nodes_[a].operands[0], b));
  return node(Op::mul, 0, {a, b});
}

Id Expressions::div(Id a, Id b) {
  if (is_constant(b, 1)) return a;
  if (is_constant(a, 0) && !is_constant(b)) return a;
  return node(Op::div, 0, {a, b});
}

Id Expressions::power(Id a, std::uint32_t n) {
  if (n == 0) return constant(1);
  if (n == 1) return a;
  if (nodes_[a].op == Op::neg) {
    const Id positive = power(nodes_[a].operands[0], n);
    return n % 2 == 0 ? positive : neg(positive);
  }
  if (n % 2 == 0 && nodes_[a].op == Op::abs) return power(nodes_[a].operands[0], n);
  return node(Op::power, n, {a});
}

Id Expressions::apply(Op function, Id a) {
  if (function == Op::abs && (nodes_[a].op == Op::abs || nodes_[a].op == Op::sqrt || nodes_[a].op == Op::exp)) return a;
  return node(function, 0, {a});
}

Id Expressions::min(Id a, Id b) {
  if (a > b) std::swap(a, b);
  return a == b ? a : node(Op::min, 0, {a, b});
}

Id Expressions::max(Id a, Id b) {
  if (a > b) std::swap(a, b);
  return a == b ? a : node(Op::max, 0, {a, b});
}

Id Expressions::choose(Id a, Id b, Id c, Id d) { return c == d ? c : node(Op::choose, 0, {a, b, c, d}); }

bool is_scaling(const Expressions& expressions, const Node& node) {
  return node.op == Op::mul && expressions.is_constant(node.operands[0]) && expressions[node.operands[0]].value() > 0;
}

std::vector<bool> needed(const Expressions& expressions, const std::vector<Id>& roots) {
  std::vector<bool> need(expressions.size(), false);
  for (const Id root : roots) need[root] = true;
  for (Id id = Id(expressions.size()); id-- > 0;) {
    if (!need[id]) continue;
    for (std::size_t i = 0; i < operand_count(expressions[id].op); ++i) need[expressions[id].operands[i]] = true;
  }
  return need;
}

namespace {

/// The derivative of node `id`, those of its operands being `slope`.
Id slope_of(Expressions& e, Id id, const std::vector<Id>& slope, const std::array<Id, 3>& seeds) {
  const Node node = e[id];  // a copy, because the graph grows
  const auto [a, b, c, d] = node.operands;
  const std::size_t count = operand_count(node.op);
  const Id zero = e.constant(0), da = count > 0 ? slope[a] : zero, db = count > 1 ? slope[b] : zero;
  switch (node.op) {
    case Op::constant:
      return zero;
    case Op::variable:
      return node.number < 3 ? seeds[node.number] : zero;
    case Op::add:
      return e.add(da, db);
    case Op::sub:
      return e.sub(da, db);
    case Op::mul:
      return e.add(e.mul(da, b), e.mul(a, db));
    case Op::div:
      return e.is_constant(b) ? e.div(da, b) : e.div(e.sub(da, e.mul(id, db)), b);
    case Op::neg:
      return e.neg(da);
    case Op::power:
      return e.mul(e.mul(e.constant(float(node.number)), e.power(a, node.number - 1)), da);
    case Op::sqrt:
      return e.div(da, e.mul(e.constant(2), id));
    case Op::abs:
      return e.choose(a, zero, e.neg(da), da);
    case Op::min:
      return e.choose(a, b, da, db);
    case Op::max:
      return e.choose(a, b, db, da);
    case Op::sin:
      return e.mul(e.apply(Op::cos, a), da);
    case Op::cos:
      return e.neg(e.mul(e.apply(Op::sin, a), da));
    case Op::exp:
      return e.mul(id, da);
    case Op::log:
      return e.div(da, a);
    case Op::atan:
      return e.div(da, e.add(e.constant(1), e.power(a, 2)));
    case Op::choose:
      return e.choose(a, b, slope[c], slope[d]);
  }
  throw InternalError("an operation without a derivative");
}

}  // namespace

Id derivative(Expressions& e, Id root, const std::array<Id, 3>& seeds) {
  const std::vector<bool> need = needed(e, {root});
  std::vector<Id> slope(root + 1, e.constant(0));
  for (Id id = 0; id <= root; ++id)
    if (need[id]) slope[id] = slope_of(e, id, slope, seeds);
  return slope[root];
}

}  // namespace eikon::formula
