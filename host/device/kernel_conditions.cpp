// SPDX-License-Identifier: Apache-2.0
#include "device/kernel_conditions.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "io/text.h"

namespace eikon {
namespace {

using Macros = std::map<std::string, bool, std::less<>>;
using Truth = std::optional<bool>;  // none: it is not known

/// Parser of a condition; unary binds more tightly than "and", and that more tightly than "or", as
/// in C.
class Condition {
 public:
  Condition(std::string_view text, const Macros& macros) : rest_(text), macros_(macros) {}

  Truth value() {
    const Truth value = any_of();
    return rest_.empty() && is_plain_ ? value : std::nullopt;
  }

 private:
  Truth any_of() { return joined('|', true, &Condition::all_of); }
  Truth all_of() { return joined('&', false, &Condition::unary); }

  /// Parts that an operator joins, which may stand once or twice. decisive: the value of a part
  /// that decides alone
  Truth joined(char op, bool decisive, Truth (Condition::*part)()) {
    Truth value = (this->*part)();
    while (take(op)) {
      take(op);
      const Truth other = (this->*part)();
      const bool decides = value == decisive || other == decisive;
      value = decides ? Truth(decisive) : value && other ? Truth(!decisive) : std::nullopt;
    }
    return value;
  }

  Truth unary() {
    if (take('!')) {
      const Truth value = unary();
      return value ? Truth(!*value) : std::nullopt;
    }
    if (take('(')) {
      const Truth value = any_of();
      is_plain_ = is_plain_ && take(')');
      return value;
    }
    std::size_t length = 0;
    while (length < rest_.size() &&
           (std::isalnum(static_cast<unsigned char>(rest_[length])) != 0 || rest_[length] == '_'))
      ++length;
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    take(' ');
    if (word == "0" || word == "1") return word == "1";
    is_plain_ = is_plain_ && !word.empty() && std::isdigit(static_cast<unsigned char>(word.front())) == 0;
    const auto found = macros_.find(word);
    return found == macros_.end() ? std::nullopt : Truth(found->second);
  }

  /// Takes a character and the spaces behind it, if the rest begins so.
  bool take(char c) {
    if (!rest_.starts_with(c)) return false;
    rest_.remove_prefix(1);
    while (rest_.starts_with(' ')) rest_.remove_prefix(1);
    return true;
  }

  std::string_view rest_;
  const Macros& macros_;
  bool is_plain_ = true;  // it has no other operators
};

/// The rest of a line behind a directive, without comments and spaces around it; none if the line
/// is not that directive.
std::optional<std::string> behind(const std::string& line, std::string_view directive) {
  if (!line.starts_with(directive)) return std::nullopt;
  std::string text = line.substr(directive.size(), line.find("//") - directive.size());
  if (!text.empty() && text.front() != ' ') return std::nullopt;
  text.erase(text.find_last_not_of(' ') + 1);
  text.erase(0, text.find_first_not_of(' '));
  return text;
}

/// An #if around the current line.
struct Region {
  Truth is_in;         // the lines are compiled; none: the compiler decides
  bool stays = false;  // its directives stay in the text
  bool taken = false;  // nothing behind a further #elif or #else is compiled
};

class Excluder {
 public:
  explicit Excluder(const std::map<std::string, std::string>& defines) {
    for (const auto& [name, value] : defines) {
      defined_.insert(name);
      if (value == "0" || value == "1") macros_[name] = value == "1";
    }
  }

  std::string run(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    while (!text.empty()) {
      const std::string_view line = take_line(text);
      if (line.starts_with('#')) {
        std::string directive(line);
        if (keep(directive)) (out += directive) += '\n';
      } else if (!is_out()) {
        (out += line) += '\n';
      }
    }
    return out;
  }

 private:
  /// Returns whether a line that begins with # stays. It may be changed.
  bool keep(std::string& line) {
    if (line.starts_with("#if")) {
      regions_.push_back(region_of(line));
      return regions_.back().stays;
    }
    if (!regions_.empty() && (line.starts_with("#el") || line.starts_with("#endif"))) return go_on(line);
    if (is_out()) return false;
    if (const auto text = behind(line, "#define")) define(*text);
    if (const auto name = behind(line, "#undef")) macros_.erase(*name);
    return true;
  }

  [[nodiscard]] Region region_of(const std::string& line) const {
    if (is_out()) return {.is_in = false, .taken = true};
    if (const auto condition = behind(line, "#if")) {
      const Truth value = Condition(*condition, macros_).value();
      return {.is_in = value, .stays = !value, .taken = value == true};
    }
    // The guard of a header: nothing but the header defines such a name.
    const auto name = behind(line, "#ifndef");
    const bool is_new = name && name->ends_with("_H") && !defined_.contains(*name);
    return {.is_in = is_new ? Truth(true) : std::nullopt, .stays = true};
  }

  /// #elif, #else and #endif.
  bool go_on(std::string& line) {
    Region& region = regions_.back();
    const bool stays = region.stays;
    if (line.starts_with("#endif")) {
      regions_.pop_back();
    } else if (stays) {
      region.is_in = std::nullopt;
    } else if (region.taken) {
      region.is_in = false;
    } else if (const auto condition = behind(line, "#elif")) {
      const Truth value = Condition(*condition, macros_).value();
      region = {.is_in = value, .stays = !value, .taken = value == true};
      line = "#if " + *condition;  // the first one of these that stays
      return region.stays;
    } else {
      region.is_in = true;
    }
    return stays;
  }

  void define(const std::string& text) {
    const std::string name = text.substr(0, text.find_first_of(" ("));
    defined_.insert(name);
    macros_.erase(name);
    for (const Region& region : regions_)
      if (!region.is_in) return;  // perhaps it is not compiled
    if (text.size() == name.size() || text[name.size()] != ' ') return;
    if (const Truth value = Condition(text.substr(name.size() + 1), macros_).value()) macros_[name] = *value;
  }

  [[nodiscard]] bool is_out() const {
    return std::ranges::any_of(regions_, [](const Region& region) { return region.is_in == false; });
  }

  Macros macros_;                  // those whose value is known
  std::set<std::string> defined_;  // all that may be defined
  std::vector<Region> regions_;
};

}  // namespace

std::string without_excluded(std::string_view text, const std::map<std::string, std::string>& defines) {
  return Excluder(defines).run(text);
}

}  // namespace eikon
