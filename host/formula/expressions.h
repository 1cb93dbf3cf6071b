// SPDX-License-Identifier: Apache-2.0
// Expressions of x, y, z and a direction as a graph in which equal ones are one, constants folded.
// Operands stand before what uses them, so that going through the nodes in order computes
// everything, and no walk recurses.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace eikon::formula {

/// power: integer exponent >= 2. choose: a < b ? c : d.
enum class Op : std::uint8_t {
  constant,
  variable,
  add,
  sub,
  mul,
  div,
  neg,
  power,
  sqrt,
  abs,
  min,
  max,
  sin,
  cos,
  exp,
  log,
  atan,
  choose
};

/// x, y, z of the point, and the direction along which a derivative is taken.
enum class Variable : std::uint32_t { x, y, z, dx, dy, dz };
inline constexpr std::uint32_t kVariables = 6;

using Id = std::uint32_t;  // of a node

struct Node {
  Op op = Op::constant;
  std::uint32_t number = 0;  // constant: the bits of its float; variable: which; power: the exponent
  std::array<Id, 4> operands{};

  auto operator<=>(const Node&) const = default;
  [[nodiscard]] float value() const;  // of a constant
};

/// An operation has a number of operands, and code on numbers and on intervals: {0} to {3} stand
/// for the operands, {4} for the node's number.
struct OpInfo {
  std::size_t operands;
  const char *number_code, *interval_code;
};
[[nodiscard]] const OpInfo& info_of(Op op);
[[nodiscard]] inline std::size_t operand_count(Op op) { return info_of(op).operands; }

/// Nodes are added, never changed. Every adding function throws InputError when the graph would
/// grow beyond kMaxNodes.
class Expressions {
 public:
  static constexpr std::size_t kMaxNodes = 4096;

  Id constant(float value);
  Id variable(Variable which);
  Id neg(Id a);
  Id add(Id a, Id b);
  Id sub(Id a, Id b);
  Id mul(Id a, Id b);
  Id div(Id a, Id b);
  /// a^n, n >= 0; 0^0 is 1.
  Id power(Id a, std::uint32_t n);
  /// sqrt abs sin cos exp log atan
  Id apply(Op function, Id a);
  Id min(Id a, Id b);
  Id max(Id a, Id b);
  /// a < b ? c : d
  Id choose(Id a, Id b, Id c, Id d);

  [[nodiscard]] const Node& operator[](Id id) const { return nodes_[id]; }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  [[nodiscard]] bool is_constant(Id id) const { return nodes_[id].op == Op::constant; }
  [[nodiscard]] bool is_constant(Id id, float value) const;

 private:
  Id node(Op op, std::uint32_t number, std::array<Id, 4> operands);
  /// `node` where all its operands are constants, computed.
  Id folded(const Node& node);
  std::vector<Node> nodes_;
  std::map<Node, Id> known_;
};

/// True of a product with a constant above 0: its interval takes two products instead of four.
[[nodiscard]] bool is_scaling(const Expressions& expressions, const Node& node);

/// Marks the nodes that the `roots` need, themselves included.
[[nodiscard]] std::vector<bool> needed(const Expressions& expressions, const std::vector<Id>& roots);

/// The derivative of `root` along a direction: seeds[i] is that of variable i (x, y, z). Where min,
/// max and abs have a kink it is that of one side.
Id derivative(Expressions& expressions, Id root, const std::array<Id, 3>& seeds);

}  // namespace eikon::formula
