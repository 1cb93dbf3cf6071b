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

// Brackets and commas outside strings bound the depth and the number of values, whether or not the text is JSON.
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

// A double that is meant as an integer would be truncated in silence, so only integer literals count.
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

std::string Place::label() const {
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

void Place::fail(const std::string& what) const { refuse(what + "; not valid glTF 2.0, export the file again"); }

void Place::refuse(const std::string& what) const { throw InputError(label() + ": " + what); }

const Json* member(const Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

const Json* as_object(const Place& place, const char* key) {
  const Json* value = member(place.value, key);
  if (value != nullptr && !value->is_object()) place.fail(fmt::format("'{}' is not an object", key));
  return value;
}

const Json* as_array(const Place& place, const char* key) {
  const Json* value = member(place.value, key);
  if (value != nullptr && !value->is_array()) place.fail(fmt::format("'{}' is not an array", key));
  return value;
}

std::optional<std::uint64_t> as_integer(const Place& place, const char* key, std::uint64_t max) {
  const Json* value = member(place.value, key);
  if (value == nullptr) return std::nullopt;
  const auto integer = unsigned_of(*value);
  if (!integer) place.fail(fmt::format("'{}' is not an integer from 0 on", key));
  if (*integer > max) place.fail(fmt::format("'{}' is {}, the largest legal value is {}", key, *integer, max));
  return integer;
}

std::uint64_t required_integer(const Place& place, const char* key, std::uint64_t max) {
  const auto integer = as_integer(place, key, max);
  if (!integer) place.fail(fmt::format("'{}' is missing", key));
  return *integer;
}

std::optional<double> as_number(const Place& place, const char* key) {
  const Json* value = member(place.value, key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_number()) place.fail(fmt::format("'{}' is not a number", key));
  return value->get<double>();
}

bool has_numbers(const Place& place, const char* key, std::size_t count) {
  const Json* array = as_array(place, key);
  if (array == nullptr) return false;
  const bool good = array->size() == count &&
                    std::all_of(array->begin(), array->end(), [](const Json& element) { return element.is_number(); });
  if (!good) place.fail(fmt::format("'{}' is not an array of {} numbers", key, count));
  return true;
}

void check_string(const Place& place, const char* key) {
  const Json* value = member(place.value, key);
  if (value != nullptr && !value->is_string()) place.fail(fmt::format("'{}' is not a string", key));
}

std::optional<std::size_t> as_index(const Place& place, const char* key, std::size_t count, std::string_view target) {
  const Json* value = member(place.value, key);
  if (value == nullptr) return std::nullopt;
  const auto integer = unsigned_of(*value);
  if (!integer) place.fail(fmt::format("'{}' is not an index of a {}", key, target));
  if (*integer >= count)
    place.fail(fmt::format("'{}' names {} {}, but there are only {}", key, target, *integer, count));
  return static_cast<std::size_t>(*integer);
}

}  // namespace eikon
