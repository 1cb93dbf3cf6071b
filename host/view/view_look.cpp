// SPDX-License-Identifier: Apache-2.0
#include "view/view_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "io/text.h"
#include "job/prepare.h"

namespace eikon {
namespace {

using FlagNames = std::set<std::string, std::less<>>;

constexpr std::size_t kLongestValue = 400;  // bytes of a flag's text
constexpr std::size_t kMaxGroups = 256;
constexpr double kMaxFactor = 1e6;  // of a light group

/// The flags that a page may give. None of them names a file, but --env, whose value is checked.
const FlagNames kLookFlags = {"--size",           "--look-at", "--fov",        "--camera",    "--f-number",
                              "--focus-distance", "--env",     "--env-rotate", "--env-scale", "--variant",
                              "--scene-time",     "--spp",     "--max-depth"};
const FlagNames kPngFlags = {"--exposure", "--tonemap"};

std::string flag_text(const std::string& name, const Json& value) {
  if (!value.is_string()) throw UsageError(fmt::format("view: {} takes a text", name));
  const std::string& text = value.get_ref<const std::string&>();
  if (text.empty() || text.size() > kLongestValue)
    throw UsageError(fmt::format("view: the value of {} has 1 to {} bytes", name, kLongestValue));
  if (name == "--env" && names_environment_file(text))
    throw UsageError("view: --env takes none, neutral or R,G,B here; name a file on the command line of `eikon view`");
  return text;
}

void check_size(const std::string& text) {
  const std::vector<std::string> sides = split(text, 'x');
  for (const std::string& side : sides) {
    const auto pixels = number_in<std::uint32_t>(side);
    if (sides.size() != 2 || !pixels || *pixels < 1 || *pixels > kMaxViewSide)
      throw UsageError(fmt::format("view: --size takes WIDTHxHEIGHT of 1 to {} pixels each", kMaxViewSide));
  }
}

void read_flag(const std::string& name, const Json& value, ViewLook& look) {
  if (!kLookFlags.contains(name) && !kPngFlags.contains(name))
    throw UsageError(fmt::format("view: a page may not give {}", in_quotes(name)));
  const std::string text = flag_text(name, value);
  if (name == "--size") check_size(text);
  (kPngFlags.contains(name) ? look.png : look.flags)[name] = text;
}

void read_factor(const std::string& group, const Json& value, ViewLook& look) {
  const double factor = value.is_number() ? value.get<double>() : -1;
  if (!(factor >= 0 && factor <= kMaxFactor) || look.mix.size() >= kMaxGroups)
    throw UsageError(fmt::format("view: the factor of a light group lies between 0 and {:g}", kMaxFactor));
  look.mix[group] = factor;
}

Json parsed_object(std::string_view text) {
  Json json;
  try {
    json = parse_json(text);
  } catch (const InputError& error) {
    throw UsageError(fmt::format("view: {}", error.what()));
  }
  if (!json.is_object()) throw UsageError("view: what a page asks for is an object");
  return json;
}

std::string_view name_of_word(std::string_view word) { return word.substr(0, word.find('=')); }

}  // namespace

const std::vector<std::string>& view_layers() {
  static const std::vector<std::string> names = {"picture", "denoised", "error", "albedo", "normal", "depth", "lights"};
  return names;
}

ViewLook read_look(std::string_view text) {
  const Json json = parsed_object(text);
  ViewLook look;
  for (const auto& [key, value] : json.items()) {
    if (key == "flags" && value.is_object()) {
      for (const auto& [name, flag] : value.items()) read_flag(name, flag, look);
    } else if (key == "mix" && value.is_object()) {
      for (const auto& [group, factor] : value.items()) read_factor(group, factor, look);
    } else if (key == "layer" && value.is_string() && std::ranges::count(view_layers(), value.get<std::string>()) > 0) {
      look.layer = value.get<std::string>();
    } else if (key == "moving" && value.is_boolean()) {
      look.moving = value.get<bool>();
    } else {
      throw UsageError(fmt::format("view: a page may not ask for {}", in_quotes(key)));
    }
  }
  if (!look.flags.contains("--size")) throw UsageError("view: the size is missing");
  return look;
}

Json look_json(const ViewLook& look) {
  Json flags = look.flags;
  flags.update(Json(look.png));
  return {{"flags", std::move(flags)}, {"layer", look.layer}, {"mix", look.mix}, {"moving", look.moving}};
}

std::vector<std::string> words_of(const ViewLook& look, const std::vector<std::string>& given) {
  const auto& flags = look.flags;
  const bool has_camera = flags.contains("--look-at") || flags.contains("--camera");
  // These flags only make sense for the camera that the user had.
  const std::set<std::string_view> of_camera = {"--look-at",  "--camera",         "--fov",
                                                "--f-number", "--focus-distance", "--panorama"};
  std::vector<std::string> words;
  for (const std::string& word : given) {
    const std::string_view name = name_of_word(word);
    if (flags.contains(std::string(name)) || (has_camera && of_camera.contains(name))) continue;
    if (name == "--frame" && flags.contains("--scene-time")) continue;
    words.push_back(word);
  }
  for (const auto& [name, value] : flags) words.push_back(fmt::format("{}={}", name, value));
  return words;
}

bool has_flag(const std::vector<std::string>& words, std::string_view flag) {
  return std::ranges::any_of(words, [&](const std::string& word) { return name_of_word(word) == flag; });
}

}  // namespace eikon
