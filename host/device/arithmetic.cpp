// SPDX-License-Identifier: Apache-2.0
#include "device/arithmetic.h"

#include <cstddef>
#include <fmt/format.h>

#include "core/error.h"
#include "device/canary.h"
#include "device/kernel_sources.h"
#include "shared/records.h"

namespace eikon {
namespace {

// The hash that PoCL, Oclgrind and every conforming device give. A test checks PoCL at each width.
constexpr std::uint32_t kExact = 0xbc69bd64;

ProgramOptions probe_options(std::uint32_t lanes, bool optimise) {
  ProgramOptions options;
  options.optimise = optimise;
  options.defines["EK_WIDTH"] = std::to_string(lanes);
  return options;
}

/// Adds the input and output of the arithmetic probe to `arguments`. returns  the output buffer
Buffer arithmetic_buffers(Device& device, Arguments& arguments) {
  const Buffer out = device.allocate(4 * EK_ARITHMETIC_WORDS);
  arguments.set("arithmetic_out", out);
  std::vector<std::uint32_t> records(64 * 16);
  for (std::uint32_t i = 0; i < records.size(); ++i) records[i] = 0x3f800000U + i * 2654435761U % 0x100000U;
  arguments.set("arithmetic_records", device.upload(records));
  return out;
}

ArithmeticClass class_of(const std::vector<std::uint32_t>& words) {
  std::uint32_t hash = 2166136261U;  // FNV-1a
  for (const std::uint32_t word : words) hash = (hash ^ word) * 16777619U;
  return {hash};
}

}  // namespace

bool ArithmeticClass::exact() const { return hash == kExact; }
std::string ArithmeticClass::name() const { return exact() ? "exact" : fmt::format("other-{:08x}", hash); }

ArithmeticClass probe_arithmetic(Device& device, std::uint32_t lanes, bool optimise) {
  Arguments arguments;
  const Buffer out = arithmetic_buffers(device, arguments);
  Kernel kernel = device.build(kernel_text({"probe/arithmetic.cl"}), probe_options(lanes, optimise)).kernel("arithmetic");
  kernel.bind(arguments);
  device.run(kernel, 1, 1);
  return class_of(device.read_all<std::uint32_t>(out));
}

ArithmeticClass trusted_arithmetic(Device& device, const Program& program) {
  Arguments arguments;
  const Canary canary(device, arguments);
  const Buffer out = arithmetic_buffers(device, arguments);
  Kernel kernel = program.kernel("probes");
  kernel.bind(arguments);
  device.run(kernel, 1, 1);
  canary.require(device);
  return class_of(device.read_all<std::uint32_t>(out));
}

void check_record_layout(Device& device, bool optimise) {
  Arguments arguments;
  const Buffer out = device.allocate(4 * 14);
  arguments.set("layout_out", out);
  Kernel kernel = device.build(kernel_text({"probe/arithmetic.cl"}), probe_options(1, optimise)).kernel("record_layout");
  kernel.bind(arguments);
  device.run(kernel, 1, 1);
  const std::vector<std::uint32_t> there = device.read_all<std::uint32_t>(out);
  struct Expected {
    const char* what;
    std::size_t value;
  };
  const Expected here[] = {
      {"size of Frame", sizeof(Frame)},
      {"Frame.environment_cos", offsetof(Frame, environment_cos)},
      {"size of Triangle", sizeof(Triangle)},
      {"Triangle.n_z", offsetof(Triangle, n_z)},
      {"size of TriangleNormals", sizeof(TriangleNormals)},
      {"TriangleNormals.v2", offsetof(TriangleNormals, v2)},
      {"size of MaterialRecord", sizeof(MaterialRecord)},
      {"MaterialRecord.emissive_texture", offsetof(MaterialRecord, emissive_texture)},
      {"size of Light", sizeof(Light)},
      {"Light.triangle", offsetof(Light, triangle)},
      {"size of AliasEntry", sizeof(AliasEntry)},
      {"AliasEntry.alias", offsetof(AliasEntry, alias)},
      {"size of Diagnostics", sizeof(Diagnostics)},
      {"Diagnostics.report", offsetof(Diagnostics, report)},
  };
  for (std::size_t i = 0; i < std::size(here); ++i)
    if (there[i] != here[i].value)
      throw InternalError(fmt::format("{} is {} on device '{}' and {} here", here[i].what, there[i], device.info().name,
                                      here[i].value));
}

}  // namespace eikon
