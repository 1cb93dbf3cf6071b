// SPDX-License-Identifier: Apache-2.0
#include "formula/parse.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "io/text.h"

namespace eikon::formula {
namespace {

constexpr std::uint32_t kMaxPower = 64;
constexpr const char* kKnown = "x y z pi e sqrt abs min max sin cos tan exp log atan sinh cosh tanh";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

class Parser {
 public:
  Parser(std::string_view text, Expressions& expressions) : text_(text), e_(expressions) {}

  Id whole() {
    const Id id = sum();
    if (peek() != '\0' || at_ < text_.size()) fail(at_, fmt::format("expected an operator before {}", here()));
    return id;
  }

 private:
  /// Counts levels of nesting for as long as it lives.
  struct Level {
    explicit Level(Parser& parser) : parser_(parser) {
      if (++parser_.depth_ > kMaxNesting)
        parser_.fail(parser_.at_, fmt::format("nested more than {} deep", kMaxNesting));
    }
    ~Level() { --parser_.depth_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;
    Parser& parser_;
  };

  [[noreturn]] static void fail(std::size_t at, const std::string& what) {
    throw InputError(fmt::format("column {}: {}", at + 1, what));
  }

  // The character at at_, for messages; UTF-8 may take several bytes for it.
  [[nodiscard]] std::string here() const {
    if (at_ >= text_.size()) return "the end";
    std::size_t end = at_ + 1;
    while (end < text_.size() && (static_cast<unsigned char>(text_[end]) & 0xC0U) == 0x80U) ++end;
    return in_quotes(text_.substr(at_, end - at_));
  }

  // Skips blanks and returns the next character, or 0 at the end.
  char peek() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
      ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  bool take(char c) {
    if (peek() != c || at_ >= text_.size()) return false;
    ++at_;
    return true;
  }

  Id sum() {
    const Level level(*this);
    Id id = product();
    for (;;) {
      const std::size_t at = at_;
      if (take('+')) {
        id = finite(e_.add(id, product()), at);
      } else if (take('-')) {
        id = finite(e_.sub(id, product()), at);
      } else {
        return id;
      }
    }
  }

  Id product() {
    Id id = signed_power();
    for (;;) {
      const std::size_t at = at_;
      if (take('*')) {
        id = finite(e_.mul(id, signed_power()), at);
      } else if (take('/')) {
        const Id divisor = signed_power();
        if (e_.is_constant(divisor, 0)) fail(at + 1, "division by zero");
        id = finite(e_.div(id, divisor), at);
      } else {
        return id;
      }
    }
  }

  Id signed_power() {
    bool negative = false;
    for (;;) {
      if (take('-')) {
        negative = !negative;
      } else if (!take('+')) {
        break;
      }
    }
    const Id id = power();
    return negative ? e_.neg(id) : id;
  }

  Id power() {
    const Id base = primary();
    if (!take('^')) return base;
    const Level level(*this);
    const std::size_t at = at_;
    const Id exponent = signed_power();
    return finite(raised(base, exponent, at), at);
  }

  Id raised(Id base, Id exponent, std::size_t at) {
    if (e_.is_constant(exponent)) {
      const float n = e_[exponent].value(), size = std::abs(n);
      if (size <= float(kMaxPower) && size == std::floor(size)) {
        const Id whole_power = e_.power(base, std::uint32_t(size));
        return n < 0 ? e_.div(e_.constant(1), whole_power) : whole_power;
      }
      if (n == 0.5F) return e_.apply(Op::sqrt, base);
    } else if (e_.is_constant(base) && !(e_[base].value() > 0)) {
      fail(at, "a power of a constant that is not positive needs a constant exponent");
    }
    return e_.apply(Op::exp, e_.mul(exponent, e_.apply(Op::log, base)));
  }

  Id primary() {
    const char c = peek();
    const std::size_t at = at_;
    if (take('(')) {
      const Id id = sum();
      if (!take(')')) fail(at_, fmt::format("expected ')' for the '(' of column {}, not {}", at + 1, here()));
      return id;
    }
    if (is_digit(c) || c == '.') return number();
    if (is_letter(c)) return named();
    fail(at, fmt::format("expected a number, a name or '(', not {}", here()));
  }

  Id number() {
    const std::size_t begin = at_;
    double value = 0;
    const char* first = text_.data() + begin;
    const auto [end, code] = std::from_chars(first, text_.data() + text_.size(), value, std::chars_format::general);
    if (code == std::errc::invalid_argument) fail(begin, "a number needs digits");
    at_ += std::size_t(end - first);
    if (code != std::errc() || std::abs(value) > 3.4028234e38) fail(begin, "the number is out of a float's range");
    return e_.constant(float(value));
  }

  Id named() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string_view name = text_.substr(begin, at_ - begin);
    if (name == "x") return e_.variable(Variable::x);
    if (name == "y") return e_.variable(Variable::y);
    if (name == "z") return e_.variable(Variable::z);
    if (name == "pi") return e_.constant(std::numbers::pi_v<float>);
    if (name == "e") return e_.constant(std::numbers::e_v<float>);
    if (name == "min" || name == "max") return least_or_most(name, begin);
    static const std::vector<std::pair<std::string_view, Op>> functions = {
        {"sqrt", Op::sqrt}, {"abs", Op::abs}, {"sin", Op::sin},  {"cos", Op::cos},
        {"exp", Op::exp},   {"log", Op::log}, {"atan", Op::atan}};
    for (const auto& [known, op] : functions)
      if (name == known) return finite(e_.apply(op, argument(name)), begin);
    if (name == "tan" || name == "sinh" || name == "cosh" || name == "tanh") return composed(name, begin);
    fail(begin, fmt::format("unknown name {}; known: {}", in_quotes(name), kKnown));
  }

  Id argument(std::string_view name) {
    const std::vector<Id> given = arguments(name);
    if (given.size() != 1) fail(at_ - 1, fmt::format("{} takes one value, not {}", name, given.size()));
    return given[0];
  }

  std::vector<Id> arguments(std::string_view name) {
    if (!take('(')) fail(at_, fmt::format("expected '(' after {}, not {}", name, here()));
    std::vector<Id> given;
    do given.push_back(sum());
    while (take(','));
    if (!take(')')) fail(at_, fmt::format("expected ',' or ')' in the values of {}, not {}", name, here()));
    return given;
  }

  Id least_or_most(std::string_view name, std::size_t at) {
    const std::vector<Id> given = arguments(name);
    if (given.size() < 2) fail(at, fmt::format("{} takes two values or more", name));
    Id id = given[0];
    for (std::size_t i = 1; i < given.size(); ++i) id = name == "min" ? e_.min(id, given[i]) : e_.max(id, given[i]);
    return id;
  }

  Id composed(std::string_view name, std::size_t at) {
    const Id a = argument(name), one = e_.constant(1);
    if (name == "tan") return finite(e_.div(e_.apply(Op::sin, a), e_.apply(Op::cos, a)), at);
    if (name == "tanh")  // 1 - 2 / (e^(2a) + 1)
      return e_.sub(one, e_.div(e_.constant(2), e_.add(e_.apply(Op::exp, e_.mul(e_.constant(2), a)), one)));
    const Id grows = e_.apply(Op::exp, a), falls = e_.apply(Op::exp, e_.neg(a));
    return finite(e_.mul(e_.constant(0.5F), name == "sinh" ? e_.sub(grows, falls) : e_.add(grows, falls)), at);
  }

  // A constant that is no number would make the whole formula none.
  Id finite(Id id, std::size_t at) const {
    if (e_.is_constant(id) && !std::isfinite(e_[id].value())) fail(at, "this constant has no finite value");
    return id;
  }

  std::string_view text_;
  Expressions& e_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Formula parse_formula(std::string_view text) {
  if (text.size() > kMaxCharacters)
    throw InputError(fmt::format("too long: {} characters; at most {}", text.size(), kMaxCharacters));
  Formula f;
  Expressions& e = f.expressions;
  f.value = Parser(text, e).whole();
  if (e.is_constant(f.value)) throw InputError("does not depend on x, y or z, so it is no surface");
  const Id zero = e.constant(0), one = e.constant(1);
  f.gradient = {derivative(e, f.value, {one, zero, zero}), derivative(e, f.value, {zero, one, zero}),
                derivative(e, f.value, {zero, zero, one})};
  f.slope = derivative(e, f.value, {e.variable(Variable::dx), e.variable(Variable::dy), e.variable(Variable::dz)});
  const std::vector<bool> used = needed(e, {f.value, f.gradient[0], f.gradient[1], f.gradient[2], f.slope});
  for (Id id = 0; id < e.size(); ++id)
    if (used[id] && e.is_constant(id) && !std::isfinite(e[id].value()))
      throw InputError("its derivative has a constant beyond a float's range; use smaller constants");
  return f;
}

}  // namespace eikon::formula
