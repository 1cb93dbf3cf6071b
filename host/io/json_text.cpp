// SPDX-License-Identifier: Apache-2.0
#include "io/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::size_t kMaxTextBytes = std::size_t{1} << 31U;  // tinygltf counts in 32 bits
constexpr std::size_t kMaxNesting = 128;                      // glTF itself needs about 10; the rest is for extras
constexpr std::size_t kMaxValues = std::size_t{1} << 25U;     // a million nodes and their members; about 2 GB as a tree

// Brackets and commas outside strings bound the depth and the number of values, even if the text is
// no JSON.
void check_shape(std::string_view text) {
  if (text.size() > kMaxTextBytes) {
    throw InputError(fmt::format("JSON text of {} bytes, at most {} are read; move the data into a .bin file or a .glb",
                                 text.size(), kMaxTextBytes));
  }
  std::size_t depth = 0, values = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      ++values;
      if (++depth > kMaxNesting) {
        throw InputError(
            fmt::format("JSON nested deeper than {} levels at byte {}; glTF needs about 10", kMaxNesting, i));
      }
    } else if (c == '}' || c == ']') {
      depth -= depth > 0 ? 1 : 0;
    } else if (c == ',') {
      ++values;
    }
  }
  if (values > kMaxValues) throw InputError(fmt::format("JSON of {} values, at most {} are read", values, kMaxValues));
}

// A double that is meant as an integer would be truncated in silence, so only integer literals
// count.
std::optional<std::uint64_t> unsigned_of(const Json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  return std::nullopt;
}

}  // namespace

Json parse_json(std::string_view text) {
  check_shape(text);
  try {
    Json document = Json::parse(text.begin(), text.end());
    if (!document.is_object()) throw InputError("JSON text is not an object");
    return document;
  } catch (const Json::exception& e) {
    std::string_view what = e.what();  // "[json.exception.parse_error.101] parse error at line 1, column 5: ..."
    if (const auto end = what.find("] "); end != std::string_view::npos) what.remove_prefix(end + 2);
    // The library quotes the last token, which may be the whole file.
    std::string line = one_line(what.substr(0, 200));
    throw InputError("not valid JSON: " + line + "; truncated or damaged?");
  }
}

std::string JsonView::label() const {
  std::string own;
  if (index < 0) {
    own = std::string(kind);
  } else {
    const Json* name = member(value, "name");
    const bool named = name != nullptr && name->is_string();
    own = eikon::label(kind, static_cast<std::uint64_t>(index),
                       named ? name->get_ref<const std::string&>() : std::string());
  }
  return parent == nullptr ? own : parent->label() + ", " + own;
}

void JsonView::fail(const std::string& what) const { refuse(what + "; not valid glTF 2.0, export the file again"); }

void JsonView::refuse(const std::string& what) const { throw InputError(label() + ": " + what); }

const Json* member(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

const Json* member(const Json* object, const char* key) { return object == nullptr ? nullptr : member(*object, key); }

/// The member, or null when absent. Fails when it is of another type.
static const Json* typed(const JsonView& view, const char* key, bool (Json::*is)() const noexcept, const char* type) {
  const Json* value = member(view.value, key);
  if (value != nullptr && !(value->*is)()) view.fail(fmt::format("'{}' is not {}", key, type));
  return value;
}

const Json* as_object(const JsonView& view, const char* key) { return typed(view, key, &Json::is_object, "an object"); }

const Json* as_array(const JsonView& view, const char* key) { return typed(view, key, &Json::is_array, "an array"); }

std::optional<std::uint64_t> as_integer(const JsonView& view, const char* key, std::uint64_t max) {
  const Json* value = member(view.value, key);
  if (value == nullptr) return std::nullopt;
  const auto integer = unsigned_of(*value);
  if (!integer) view.fail(fmt::format("'{}' is not an integer from 0 on", key));
  if (*integer > max) view.fail(fmt::format("'{}' is {}, the largest legal value is {}", key, *integer, max));
  return integer;
}

std::uint64_t required_integer(const JsonView& view, const char* key, std::uint64_t max) {
  const auto integer = as_integer(view, key, max);
  if (!integer) view.fail(fmt::format("'{}' is missing", key));
  return *integer;
}

std::optional<double> as_number(const JsonView& view, const char* key) {
  const Json* value = typed(view, key, &Json::is_number, "a number");
  return value == nullptr ? std::nullopt : std::optional(value->get<double>());
}

bool has_numbers(const JsonView& view, const char* key, std::size_t count) {
  const Json* array = as_array(view, key);
  if (array == nullptr) return false;
  const bool good = array->size() == count &&
                    std::all_of(array->begin(), array->end(), [](const Json& element) { return element.is_number(); });
  if (!good) view.fail(fmt::format("'{}' is not an array of {} numbers", key, count));
  return true;
}

const std::string* as_string(const JsonView& view, const char* key) {
  const Json* value = typed(view, key, &Json::is_string, "a string");
  return value == nullptr ? nullptr : &value->get_ref<const std::string&>();
}

std::optional<std::size_t> as_index(const JsonView& view, const char* key, std::size_t count, std::string_view target) {
  const Json* value = member(view.value, key);
  if (value == nullptr) return std::nullopt;
  const auto integer = unsigned_of(*value);
  if (!integer) view.fail(fmt::format("'{}' is not an index of a {}", key, target));
  if (*integer >= count)
    view.fail(fmt::format("'{}' names {} {}, but there are only {}", key, target, *integer, count));
  return static_cast<std::size_t>(*integer);
}

bool is_object(const Json& value) { return value.is_object(); }
bool is_string(const Json& value) { return value.is_string(); }
bool is_boolean(const Json& value) { return value.is_boolean(); }

bool is_index(const Json& value, std::size_t count) {
  const auto integer = unsigned_of(value);
  return integer && *integer < count;
}

bool equals(const Json* value, std::string_view text) {
  return value != nullptr && value->is_string() && value->get_ref<const std::string&>() == text;
}

double to_number(const Json& value) { return value.get<double>(); }
std::size_t to_index(const Json& value) { return value.get<std::size_t>(); }
bool to_boolean(const Json& value) { return value.get<bool>(); }
const std::string& to_string(const Json& value) { return value.get_ref<const std::string&>(); }
std::string excerpt(const Json& value) { return one_line(value.dump(-1, ' ', true).substr(0, 40)); }

const Json& empty_array() {
  static const Json kNone = Json::array();
  return kNone;
}

const Json& empty_object() {
  static const Json kNone = Json::object();
  return kNone;
}

std::size_t size_of(const Json& array) { return array.size(); }
const Json& element(const Json& array, std::size_t i) { return array[i]; }
double number_at(const Json& array, std::size_t i) { return array[i].get<double>(); }

std::vector<JsonMember> members(const Json* object) {
  std::vector<JsonMember> all;
  if (object == nullptr || !object->is_object()) return all;
  for (const auto& entry : object->items()) all.push_back({.key = entry.key(), .value = entry.value()});
  return all;
}

}  // namespace eikon
