// SPDX-License-Identifier: Apache-2.0
#include "formula/kernel_code.h"

#include <fmt/format.h>

#include "core/error.h"

namespace eikon::formula {
namespace {

std::string literal(float value) { return fmt::format("(vf)({:a}f)", double(value)); }

std::string name(Id id) { return fmt::format("v{}", id); }

// The code of a node by its row of OpInfo; its operands are variables of the text.
std::string code(const char* format, const Node& node) {
  const auto& o = node.operands;
  return fmt::format(fmt::runtime(format), name(o[0]), name(o[1]), name(o[2]), name(o[3]), node.number);
}

std::string number_code(const Node& node) {
  static constexpr const char* kNumbers[kVariables] = {"p.x", "p.y", "p.z", "d.x", "d.y", "d.z"};
  if (node.op == Op::constant) return literal(node.value());
  if (node.op == Op::variable) return kNumbers[node.number];
  return code(info_of(node.op).number_code, node);
}

std::string interval_code(const Expressions& e, const Node& node) {
  static constexpr const char* kIntervals[kVariables] = {
      "x", "y", "z", "interval_point(d.x)", "interval_point(d.y)", "interval_point(d.z)"};
  if (node.op == Op::constant) return "interval_point(" + literal(node.value()) + ")";
  if (node.op == Op::variable) return kIntervals[node.number];
  return code(is_scaling(e, node) ? "interval_scale({0}.lo, {1})" : info_of(node.op).interval_code, node);
}

std::string number_lines(const Expressions& e, const std::vector<Id>& roots) {
  const std::vector<bool> need = needed(e, roots);
  std::string text;
  for (Id id = 0; id < e.size(); ++id)
    if (need[id]) text += fmt::format("  const vf {} = {};\n", name(id), number_code(e[id]));
  return text;
}

std::string interval_lines(const Expressions& e, const std::vector<Id>& roots) {
  const std::vector<bool> need = needed(e, roots);
  std::string text;
  for (Id id = 0; id < e.size(); ++id) {
    if (!need[id]) continue;
    const Node& node = e[id];
    text += fmt::format("  const Interval {} = {};\n", name(id), interval_code(e, node));
    if (node.op == Op::sqrt || node.op == Op::log)
      text += fmt::format("  r.undefined = r.undefined | interval_{}_undefined({});\n",
                          node.op == Op::sqrt ? "sqrt" : "log", name(node.operands[0]));
  }
  return text;
}

std::string one(const Formula& f, std::size_t index) {
  std::string text = fmt::format("EK_FN_ONCE vf implicit_value_{}(v3 p) {{\n", index);
  text += number_lines(f.expressions, {f.value});
  text += fmt::format("  return {};\n}}\nEK_FN_ONCE v3 implicit_gradient_{}(v3 p) {{\n", name(f.value), index);
  text += number_lines(f.expressions, {f.gradient.begin(), f.gradient.end()});
  text += fmt::format("  return V3({}, {}, {});\n}}\n", name(f.gradient[0]), name(f.gradient[1]), name(f.gradient[2]));
  text +=
      fmt::format("EK_FN_ONCE ImplicitBounds implicit_bounds_{}(Interval x, Interval y, Interval z, v3 d) {{\n", index);
  text += "  ImplicitBounds r;\n  r.undefined = (vi)(0);\n";
  text += interval_lines(f.expressions, {f.value, f.slope});
  text += fmt::format("  r.value = {};\n  r.slope = {};\n  return r;\n}}\n", name(f.value), name(f.slope));
  return text;
}

// A function that calls the one of its formula. The last formula is the default case.
std::string chosen(const char* result, const char* function, const char* parameters, const char* values,
                   std::size_t count) {
  std::string text =
      fmt::format("EK_FN {} {}(uint formula, {}) {{\n  switch (formula) {{\n", result, function, parameters);
  for (std::size_t i = 0; i + 1 < count; ++i)
    text += fmt::format("    case {}u: return {}_{}({});\n", i, function, i, values);
  text += fmt::format("    default: return {}_{}({});\n  }}\n}}\n", function, count - 1, values);
  return text;
}

}  // namespace

std::string kernel_code(const std::vector<Formula>& formulas) {
  if (formulas.empty()) throw InternalError("kernel code for no formula");
  std::string text = "// Written by eikon, host/formula/kernel_code.cpp.\n";
  for (std::size_t i = 0; i < formulas.size(); ++i) text += one(formulas[i], i);
  text += chosen("vf", "implicit_value", "v3 p", "p", formulas.size());
  text += chosen("v3", "implicit_gradient", "v3 p", "p", formulas.size());
  text += chosen("ImplicitBounds", "implicit_bounds", "Interval x, Interval y, Interval z, v3 d", "x, y, z, d",
                 formulas.size());
  return text;
}

}  // namespace eikon::formula
