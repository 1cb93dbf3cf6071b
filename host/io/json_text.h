// SPDX-License-Identifier: Apache-2.0
// JSON text to a tree, for text that may be hostile; and the two ways in which the loader asks that tree for values.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace eikon {

using Json = nlohmann::json;

/// Parses one JSON object.
/// Nesting and the number of values are bounded on the bytes, before any parser sees them: tinygltf copies trees by
/// recursion, and a tree takes many times the memory of its text.
/// throws InputError: nesting, number of values, syntax (with line and column), number out of range, not an object
Json parse_json(std::string_view text);

/// A JSON value together with where it stands, for messages. Cheap: the text is made when something is wrong.
struct Place {
  const Json& value;
  std::string_view kind;          // "node", or a member's name below `parent`
  std::int64_t index = -1;        // -1: none
  const Place* parent = nullptr;  // outlives this

  /// "node 'lamp'", "mesh 'box', primitive 2"
  [[nodiscard]] std::string label() const;
  /// throws InputError("<label>: <what>") and, as nothing but the file is to blame, the advice to export it again.
  [[noreturn]] void fail(const std::string& what) const;
  /// throws InputError("<label>: <what>"), where `what` says what to try.
  [[noreturn]] void refuse(const std::string& what) const;
};

/// The member `key` of an object, or null when it is absent.
[[nodiscard]] const Json* member(const Json& object, const char* key);

/// Optional and required members, by type; throw InputError when present and of another type or out of range.
/// `as_object` and `as_array` return null when absent.
const Json* as_object(const Place& place, const char* key);
const Json* as_array(const Place& place, const char* key);
std::optional<std::uint64_t> as_integer(const Place& place, const char* key, std::uint64_t max);
std::uint64_t required_integer(const Place& place, const char* key, std::uint64_t max);
std::optional<double> as_number(const Place& place, const char* key);
/// Whether `key` is there; then it is an array of exactly `count` numbers.
bool has_numbers(const Place& place, const char* key, std::size_t count);
void check_string(const Place& place, const char* key);
/// An index into an array of `count` things called `target`.
std::optional<std::size_t> as_index(const Place& place, const char* key, std::size_t count, std::string_view target);

}  // namespace eikon
