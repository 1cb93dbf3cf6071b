// SPDX-License-Identifier: Apache-2.0
#include "kernels/probe.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <climits>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <tuple>
#include <utility>

#include "device/device.h"
#include "device/kernel_sources.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

namespace eikon::test {
namespace {

using Defines = std::map<std::string, std::string>;

struct Variant {
  unsigned width;
  bool portable;  // without the processor's own instructions
};
constexpr Variant kVariants[] = {{16, false}, {1, false}, {8, false}, {16, true}};  // the fastest first

/// Features that change what other subjects compute or are given.
bool off_unless_asked(std::string_view name) {
  return name == "uniform_scatter" || name == "shape" || name == "instance" || name == "light_tree" ||
         name == "one_light" || name == "nested_media" || name == "open_solid" || name == "each_light" ||
         name == "energy_compensation" || name == "guiding" || name == "path_log" || name == "merging" ||
         name == "camera_motion" || name == "moving_surface" || name == "moving_light" || name == "motion";
}

Defines default_defines() {
  return {
#define EK_LOBE(name, bit, traits) {"EK_HAS_" #name, "1"},
#define EK_LIGHT(name, bit) {"EK_HAS_" #name, "1"},
#define EK_OPTION(name) {"EK_HAS_" #name, off_unless_asked(#name) ? "0" : "1"},
#define EK_SHAPE_KIND(name, bit) {"EK_HAS_" #name, "0"},
#define EK_AOV(name, channels) {"EK_HAS_" #name, off_unless_asked(#name) ? "0" : "1"},
#include "shared/features.def"
  };
}

/// The devices and programs of this process. Closed before main returns: drivers do not outlive it.
struct Opened : testing::Environment {
  std::vector<std::unique_ptr<Device>> devices;
  // By a hash of their text.
  std::map<std::tuple<const Device*, std::size_t, Defines, bool, std::string>, Program> programs;
  // Blocks of megabytes come and go with each run: kept, they cost no system calls and no pages
  // that are cleared.
  void SetUp() override {
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    mallopt(M_TRIM_THRESHOLD, INT_MAX);
  }
  void TearDown() override {
    programs.clear();
    devices.clear();
  }
};
Opened* const opened = static_cast<Opened*>(testing::AddGlobalTestEnvironment(new Opened));  // owned by GoogleTest

/// A file of tests/kernels, with what it includes.
std::string text_of(const std::string& path) {
  const std::filesystem::path file = std::filesystem::path(EIKON_SOURCE_DIR "/tests/kernels") / path;
  const std::string text = read_bytes(file);
  if (text.empty()) throw std::runtime_error("cannot read " + file.string());
  return expand_includes(text, file.filename().string());
}

const HashedText& probe_text() {
  static const HashedText text = text_of("probes.cl");
  return text;
}

}  // namespace

std::vector<std::unique_ptr<Device>>& devices() {
  if (opened->devices.empty())
    for (const DeviceInfo& info : list_devices())
      if (info.unusable.empty()) opened->devices.push_back(std::make_unique<Device>(info));
  if (opened->devices.empty()) throw std::runtime_error("no OpenCL device: install pocl-opencl-icd");
  return opened->devices;
}

const Program& program_of(Device& device, const HashedText& text, const ProgramOptions& options) {
  const auto key = std::tuple(&std::as_const(device), text.hash, options.defines, options.optimise, options.extra_flags);
  const auto found = opened->programs.find(key);
  if (found != opened->programs.end()) return found->second;
  return opened->programs.emplace(key, device.build(text.text, options)).first->second;
}

namespace {

/// The item of `items` that is number i of `asked` of them, evenly chosen; the last one where there
/// are fewer.
std::size_t chosen(std::size_t i, std::size_t asked, std::size_t items) {
  return asked < items ? i * items / asked : std::min(i, items - 1);
}

/// The chosen items of each input, one input behind the other.
Words side_by_side(const std::vector<Words>& inputs, std::size_t asked) {
  Words in;
  in.reserve(inputs.size() * asked);
  for (const Words& input : inputs) {
    if (asked >= input.size()) {
      in.insert(in.end(), input.begin(), input.end());
      in.resize(in.size() + asked - input.size(), input.back());
      continue;
    }
    for (std::size_t i = 0; i < asked; ++i) in.push_back(input[chosen(i, asked, input.size())]);
  }
  return in;
}

}  // namespace

Words as_words(const std::vector<float>& values) {
  Words words;
  words.reserve(values.size());
  for (const float x : values) words.push_back(as_word(x));
  return words;
}

Probe& Probe::define(const std::string& name, const std::string& value) {
  defines_[name] = value;
  return *this;
}

Probe& Probe::value(const std::string& name, std::uint32_t word) {
  values_[name] = word;
  return *this;
}

Probe& Probe::compare(std::size_t items) {
  compared_ = items;
  return *this;
}

Probe& Probe::append(std::string text) {
  appended_ = std::move(text);
  return *this;
}

Probe& Probe::append_file(const std::string& path) { return append(text_of(path)); }

std::vector<Words> Probe::run(const std::string& name, const std::vector<Words>& inputs, unsigned outputs) const {
  const std::size_t items = inputs.at(0).size();
  for (const Words& input : inputs)
    if (input.size() != items || items == 0) throw std::logic_error("inputs of a probe differ in length, or are empty");
  const std::size_t padded = (items + 15) / 16 * 16;
  Words first;
  std::string first_label;
  const HashedText with_functions(appended_.empty() ? std::string() : probe_text().text + appended_);
  const HashedText& text = appended_.empty() ? probe_text() : with_functions;
  for (const auto& opened_device : devices()) {
    Device& device = *opened_device;
    Arguments arguments;
    for (const auto& [buffer, words] : buffers_) arguments.set(buffer, device.upload(words));
    for (const auto& [scalar, word] : values_) arguments.set(scalar, word);
    std::size_t given = 0;  // items that the device has
    for (const Variant& variant : kVariants) {
      Defines defines = default_defines();
      for (const auto& [key, value] : defines_) defines[key] = value;
      defines["EK_WIDTH"] = std::to_string(variant.width);
      defines.emplace("EK_PROBE_" + subject_, "1");
      if (variant.portable) defines.emplace("EK_PORTABLE", "1");
      // Functions stay functions, as far as the compiler likes: the same arithmetic, since nothing
      // is contracted across them, and a program of all lobes compiles in a fraction of the time.
      // Whole images are of programs as devices are given them.
      defines.emplace("EK_OUT_OF_LINE", "1");
      const std::size_t asked = first.empty() ? padded : std::min(padded, compared_);
      if (asked != given) {
        arguments.set("in_words", device.upload(side_by_side(inputs, asked)));
        arguments.set("count", std::uint32_t(asked));
        given = asked;
      }
      // Poisoned, so that an item that a probe leaves out shows.
      const Buffer out = device.upload(Words(asked * outputs, 0xdeadbeefU));
      arguments.set("out_words", out);
      const bool oclgrind = device.info().platform.find("Oclgrind") != std::string::npos;
      Kernel kernel = program_of(device, text, {.defines = defines, .optimise = !oclgrind}).kernel(name);
      kernel.bind(arguments);
      device.run(kernel, asked / variant.width, 1, asked);
      Words result = device.read_all<std::uint32_t>(out);
      const std::string label =
          device.info().name + ", width " + std::to_string(variant.width) + (variant.portable ? ", portable" : "");
      if (first.empty()) {
        first = std::move(result);
        first_label = label;
        continue;
      }
      std::size_t different = 0, example = 0;
      for (std::size_t k = 0; k < outputs; ++k) {
        for (std::size_t i = 0; i < asked; ++i)
          if (result[k * asked + i] != first[k * padded + chosen(i, asked, items)] && different++ == 0)
            example = k * asked + i;
      }
      const std::size_t example_output = example / asked, example_item = chosen(example % asked, asked, items);
      const std::uint32_t found = result[example], expected = first[example_output * padded + example_item];
      EXPECT_EQ(different, 0U) << name << ": words differ between " << label << " and " << first_label
                               << "; first: output " << example_output << " of item " << example_item << ": "
                               << as_float(found) << " and " << as_float(expected) << std::hex << " (0x" << found
                               << ", 0x" << expected << ")";
    }
  }
  std::vector<Words> split;
  for (unsigned k = 0; k < outputs; ++k)
    split.emplace_back(first.begin() + std::ptrdiff_t(k * padded), first.begin() + std::ptrdiff_t(k * padded + items));
  return split;
}

}  // namespace eikon::test
