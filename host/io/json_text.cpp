// SPDX-License-Identifier: Apache-2.0
#include "io/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "core/error.h"
#include "io/text.h"
#include "io/xxhash64.h"

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

// A string lies in the bytes [begin, end) of the JSON text; its quotes are outside of them.
struct Piece {
  std::size_t begin, end;
};

// The values that are long and plain, as data in base64 are: printable ASCII without escapes. The
// parser would hold each three times, so it gets a placeholder instead.
std::vector<Piece> long_values(std::string_view text) {
  constexpr std::size_t kLong = std::size_t{1} << 16U;
  const auto is_plain = [](char c) { return c >= 0x20 && c < 0x7F; };
  std::vector<Piece> found;
  for (std::size_t i = text.find('"'); i != std::string_view::npos; i = text.find('"', i + 1)) {
    const std::size_t begin = i + 1;
    for (i = begin; i < text.size() && text[i] != '"'; ++i)
      if (text[i] == '\\') ++i;
    if (i >= text.size()) break;  // the string does not end, and the parser says so
    const std::string_view string = text.substr(begin, i - begin);
    if (string.size() < kLong || string.find('\\') != std::string_view::npos) continue;
    const std::size_t next = text.find_first_not_of(" \t\r\n", i + 1);
    const bool is_name = next != std::string_view::npos && text[next] == ':';
    if (!is_name && std::all_of(string.begin(), string.end(), is_plain)) found.push_back({begin, i});
  }
  return found;
}

// Puts the long values back in, each once. The walk goes by the structure, which is bounded.
void restore(Json& value, std::map<std::string, std::string_view>& long_value_of) {
  if (value.is_structured()) {
    for (Json& part : value) restore(part, long_value_of);
  } else if (value.is_string()) {
    const auto found = long_value_of.find(value.get_ref<const std::string&>());
    if (found == long_value_of.end()) return;
    value = std::string(found->second);
    long_value_of.erase(found);
  }
}

Json parse_in_pieces(std::string_view text) {
  const std::vector<Piece> pieces = long_values(text);
  if (pieces.empty()) return Json::parse(text.begin(), text.end());
  // A text that holds a placeholder of its own would have to know its hash, and gain nothing.
  const std::uint64_t hash = xxhash64(std::as_bytes(std::span(text)), 0);
  std::string rest;
  std::map<std::string, std::string_view> long_value_of;
  std::size_t from = 0;
  for (const Piece& piece : pieces) {
    const std::string name = fmt::format("{:016x}:{}", hash, long_value_of.size());
    rest.append(text.substr(from, piece.begin - from)).append(name);
    long_value_of.emplace(name, text.substr(piece.begin, piece.end - piece.begin));
    from = piece.end;
  }
  rest.append(text.substr(from));
  Json document = Json::parse(rest);
  restore(document, long_value_of);
  return document;
}

// JSON has one kind of number, and a file may write 1 as 1.0 or 1e0 [glTF 2.0, section 2.7.2]. What
// is whole becomes an integer here, so that all who ask for one, libraries too, get it.
void make_whole_numbers_integers(Json& value) {
  constexpr double kMaxExact = 9007199254740992.0;  // 2^53: beyond, a double may stand for another integer
  if (value.is_structured()) {
    for (Json& part : value) make_whole_numbers_integers(part);  // as deep as kMaxNesting
  } else if (value.is_number_float()) {
    const auto number = value.get<double>();
    if (number <= kMaxExact && !std::signbit(number) && number == std::trunc(number))
      value = static_cast<std::uint64_t>(number);
  }
}

// A fraction that is meant as an integer would be truncated in silence, so it does not count.
std::optional<std::uint64_t> unsigned_of(const Json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  return std::nullopt;
}

}  // namespace

Json parse_json(std::string_view text) {
  check_shape(text);
  try {
    Json document = parse_in_pieces(text);
    if (!document.is_object()) throw InputError("JSON text is not an object");
    make_whole_numbers_integers(document);
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
bool is_array(const Json& value) { return value.is_array(); }
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
