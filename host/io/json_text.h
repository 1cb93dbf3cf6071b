// SPDX-License-Identifier: Apache-2.0
// JSON text to a tree, for text that may be hostile, and how readers ask that tree for values. Only
// files that change a tree need to include the JSON library itself.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

using Json = nlohmann::json;

/// Parses one JSON object; whole numbers are integers, however they are written. Nesting and the
/// number of values are bounded on the bytes, before any parser sees them: tinygltf copies trees by
/// recursion, and a tree takes many times the memory of its text.
/// throws InputError: nesting, number of values, syntax (with line and column), number out of
///        range, not an object
Json parse_json(std::string_view text);

/// A JSON value together with where it stands, for messages. It is cheap: the text is made only
/// when something is wrong.
struct JsonView {
  const Json& value;
  std::string_view kind;             // "node", or a member's name below `parent`
  std::int64_t index = -1;           // in its array; -1: it is in none
  const JsonView* parent = nullptr;  // outlives this

  /// "node 'lamp'", "mesh 'box', primitive 2"
  [[nodiscard]] std::string label() const;
  /// throws InputError("<label>: <what>") and, as nothing but the file is to blame, the advice to
  ///        export it again.
  [[noreturn]] void fail(const std::string& what) const;
  /// throws InputError("<label>: <what>"), where `what` says what to try.
  [[noreturn]] void refuse(const std::string& what) const;
};

/// The member `key` of an object, or null when it is absent.
[[nodiscard]] const Json* member(const Json& object, const char* key);
/// The same of an object that may itself be absent.
[[nodiscard]] const Json* member(const Json* object, const char* key);

/// Optional and required members, by type; throw InputError when present and of another type or out
/// of range. `as_object` and `as_array` return null when absent.
const Json* as_object(const JsonView& view, const char* key);
const Json* as_array(const JsonView& view, const char* key);
std::optional<std::uint64_t> as_integer(const JsonView& view, const char* key, std::uint64_t max);
std::uint64_t required_integer(const JsonView& view, const char* key, std::uint64_t max);
std::optional<double> as_number(const JsonView& view, const char* key);
/// Returns whether `key` is there; if so it is an array of exactly `count` numbers.
bool has_numbers(const JsonView& view, const char* key, std::size_t count);
/// Returns the text, or null when absent.
const std::string* as_string(const JsonView& view, const char* key);
/// An index into an array of `count` things called `target`.
std::optional<std::size_t> as_index(const JsonView& view, const char* key, std::size_t count, std::string_view target);

// The rest is for values whose type has been checked, or whose type is the question.

[[nodiscard]] bool is_object(const Json& value);
[[nodiscard]] bool is_array(const Json& value);
[[nodiscard]] bool is_string(const Json& value);
[[nodiscard]] bool is_boolean(const Json& value);
/// True for an integer from 0 to `count` - 1.
[[nodiscard]] bool is_index(const Json& value, std::size_t count);
/// True for the string `text`.
[[nodiscard]] bool equals(const Json* value, std::string_view text);
[[nodiscard]] double to_number(const Json& value);
[[nodiscard]] std::size_t to_index(const Json& value);
[[nodiscard]] bool to_boolean(const Json& value);
[[nodiscard]] const std::string& to_string(const Json& value);
/// The first 40 characters of a value's own text, fit for one line.
[[nodiscard]] std::string excerpt(const Json& value);

/// These stand for an absent array or object.
[[nodiscard]] const Json& empty_array();
[[nodiscard]] const Json& empty_object();

/// Elements of an array, by their numbers.
[[nodiscard]] std::size_t size_of(const Json& array);
[[nodiscard]] const Json& element(const Json& array, std::size_t i);
[[nodiscard]] double number_at(const Json& array, std::size_t i);

struct JsonMember {
  const std::string& key;
  const Json& value;
};
/// The members of an object, ordered by name; none if `object` is null.
[[nodiscard]] std::vector<JsonMember> members(const Json* object);

}  // namespace eikon
