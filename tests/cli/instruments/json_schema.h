// SPDX-License-Identifier: Apache-2.0
// As much of JSON Schema (draft 7) as ours use; a keyword that is none of these is an error.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace eikon::test {

class JsonSchema {
 public:
  explicit JsonSchema(nlohmann::json schema) : root_(std::move(schema)) {}
  /// What is wrong with `value`, one line each. Stricter than the schema: a property that it does
  /// not describe is wrong too.
  std::vector<std::string> errors(const nlohmann::json& value) const {
    std::vector<std::string> found;
    check(root_, value, "$", found);
    return found;
  }

 private:
  using json = nlohmann::json;
  json root_;

  static bool has_type(const json& value, const std::string& type) {
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "array") return value.is_array();
    if (type == "object") return value.is_object();
    return type == "null" && value.is_null();
  }

  void check(const json& schema, const json& value, const std::string& where, std::vector<std::string>& found) const {
    static const std::set<std::string> known = {"$schema",     "$ref",    "title",    "description",
                                                "definitions", "type",    "required", "properties",
                                                "items",       "minimum", "const",    "enum"};
    for (const auto& [keyword, rule] : schema.items())
      if (known.count(keyword) == 0) found.push_back(where + ": keyword " + keyword + " is not checked");
    if (schema.contains("$ref"))
      check(root_.at(json::json_pointer(schema.at("$ref").get<std::string>().substr(1))), value, where, found);
    if (schema.contains("type")) {
      const json types = schema.at("type").is_array() ? schema.at("type") : json::array({schema.at("type")});
      if (std::none_of(types.begin(), types.end(), [&](const json& type) { return has_type(value, type); }))
        found.push_back(fmt::format("{}: {} is not {}", where, value.dump(), types.dump()));
    }
    if (schema.contains("const") && value != schema.at("const")) found.push_back(where + ": another constant");
    if (schema.contains("enum") && std::ranges::find(schema.at("enum"), value) == schema.at("enum").end())
      found.push_back(where + ": " + value.dump() + " is not listed");
    if (schema.contains("minimum") && value.is_number() && value < schema.at("minimum"))
      found.push_back(fmt::format("{}: {} is too small", where, value.dump()));
    if (value.is_object() && schema.contains("properties")) check_object(schema, value, where, found);
    if (value.is_array() && schema.contains("items"))
      for (std::size_t i = 0; i < value.size(); ++i)
        check(schema.at("items"), value[i], fmt::format("{}[{}]", where, i), found);
  }

  void check_object(const json& schema, const json& value, const std::string& where,
                    std::vector<std::string>& found) const {
    for (const json& name : schema.value("required", json::array()))
      if (!value.contains(name.get<std::string>())) found.push_back(where + ": no " + name.get<std::string>());
    for (const auto& [name, property] : value.items()) {
      if (schema.at("properties").contains(name))
        check(schema.at("properties").at(name), property, where + "." + name, found);
      else
        found.push_back(where + ": " + name + " is not described");
    }
  }
};

}  // namespace eikon::test
