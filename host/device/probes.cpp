// SPDX-License-Identifier: Apache-2.0
#include "device/probes.h"

#include <cstddef>
#include <fmt/format.h>

#include "device/kernel_sources.h"
#include "shared/canary.h"
#include "shared/records.h"

namespace eikon {
namespace {

constexpr std::uint32_t kRecordWords = 16, kFlagsWord = offsetof(Triangle, flags) / 4;
static_assert(sizeof(Triangle) == 4 * kRecordWords);

constexpr std::uint32_t mix(std::uint32_t x) {
  x = (x ^ (x >> 15)) * 2654435761U;
  return x ^ (x >> 13);
}
constexpr std::uint32_t record(std::uint32_t x) { return x & (EK_CANARY_RECORDS - 1U); }

/// A value that differs in each buffer. It is a finite float, which no driver has a reason to
/// change.
std::vector<std::uint32_t> finite_words(std::uint32_t buffer, std::uint32_t words) {
  std::vector<std::uint32_t> out(words);
  for (std::uint32_t i = 0; i < words; ++i) out[i] = 0x3f800000U | (mix(i + buffer * 0x01000193U) & 0x7fffffU);
  return out;
}

struct Contents {
  std::vector<std::uint32_t> triangles = finite_words(1, kRecordWords* EK_CANARY_RECORDS);
  std::vector<std::uint32_t> other = finite_words(2, kRecordWords* EK_CANARY_RECORDS);
  std::vector<std::uint32_t> words = finite_words(3, EK_CANARY_RECORDS);
  std::vector<std::uint32_t> floats = finite_words(4, EK_CANARY_RECORDS);
};

const Contents& contents() {
  static const Contents in;
  return in;
}

/// Computes what the kernel computes, one lane at a time.
std::uint32_t expected_word(std::uint32_t i, const Contents& in) {
  std::uint32_t fold = mix(i);
  for (std::uint32_t round = 0; round < 4; ++round) {
    const std::uint32_t* const r = &in.triangles[std::size_t{kRecordWords} * record(fold)];
    fold = mix(fold ^ r[0] ^ (r[6] << 3) ^ (r[15] << 6));
    fold = mix(fold ^ in.triangles[std::size_t{kRecordWords} * record(fold) + 9]);
    fold = mix(fold ^ in.words[record(fold)]);
    fold = mix(fold ^ in.floats[record(fold)]);
    const std::uint32_t* const s = &in.other[std::size_t{kRecordWords} * record(fold)];
    fold = mix(fold ^ s[1] ^ (s[7] << 3) ^ (s[12] << 6));
    fold = mix(fold ^ in.triangles[std::size_t{kRecordWords} * (round * 1021U + 5U) + kFlagsWord]);
  }
  return fold;
}

/// Adds the buffers of the memory probe (kernels/probe/canary.h) to `arguments`. returns  the
///                                                                                        output
Buffer canary_buffers(Device& device, Arguments& arguments) {
  const Contents& in = contents();
  const Buffer out = device.allocate(4 * EK_CANARY_WORDS);
  arguments.set("canary_out", out);
  arguments.set("canary_triangles", device.upload(in.triangles));
  arguments.set("canary_other", device.upload(in.other));
  arguments.set("canary_words", device.upload(in.words));
  arguments.set("canary_floats", device.upload(in.floats));
  return out;
}

/// throws UntrustedDevice unless the memory probe that has run gave what it should
void require_right_words(Device& device, const Buffer& out) {
  const std::vector<std::uint32_t> found = device.read_all<std::uint32_t>(out);
  std::size_t wrong = 0;
  for (std::uint32_t i = 0; i < EK_CANARY_WORDS; ++i) wrong += found[i] != expected_word(i, contents()) ? 1 : 0;
  if (wrong > 0)
    throw UntrustedDevice(fmt::format(
        "device '{}' is not to be trusted: its driver ({} {}) reads memory wrongly ({} of {} words of a probe); choose "
        "another device (--devices), or another driver for it",
        device.info().name, device.info().platform, device.info().driver, wrong, found.size()));
}

void run_once(Device& device, Kernel kernel, const Arguments& arguments) {
  kernel.bind(arguments);
  device.run(kernel, 1, 1);
}

// The hash that PoCL, Oclgrind and every conforming device give. A test checks PoCL at each width.
constexpr std::uint32_t kExact = 0xbc69bd64;

Program arithmetic_program(Device& device, std::uint32_t lanes, bool optimise) {
  return device.build(kernel_text({"probe/arithmetic.cl"}),
                      {.defines = {{"EK_WIDTH", std::to_string(lanes)}}, .optimise = optimise});
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

void require_canary(Device& device, const Program& program) {
  Arguments arguments;
  const Buffer out = canary_buffers(device, arguments);
  run_once(device, program.kernel("canary"), arguments);
  require_right_words(device, out);
}

bool passes_canary(const DeviceInfo& info) {
  try {
    Device device(info);
    ProgramOptions options;
    options.defines["EK_WIDTH"] = !info.cpu ? "1" : info.native_float_lanes >= 16 ? "16" : "8";
    require_canary(device, device.build(kernel_text({"probe/canary.cl"}), options));
    return true;
  } catch (const DeviceError&) {
    return false;
  }
}

bool ArithmeticClass::exact() const { return hash == kExact; }
std::string ArithmeticClass::name() const { return exact() ? "exact" : fmt::format("other-{:08x}", hash); }

ArithmeticClass probe_arithmetic(Device& device, std::uint32_t lanes, bool optimise) {
  Arguments arguments;
  const Buffer out = arithmetic_buffers(device, arguments);
  run_once(device, arithmetic_program(device, lanes, optimise).kernel("arithmetic"), arguments);
  return class_of(device.read_all<std::uint32_t>(out));
}

ArithmeticClass trusted_arithmetic(Device& device, const Program& program) {
  Arguments arguments;
  const Buffer canary = canary_buffers(device, arguments), out = arithmetic_buffers(device, arguments);
  run_once(device, program.kernel("probes"), arguments);
  require_right_words(device, canary);
  return class_of(device.read_all<std::uint32_t>(out));
}

void check_record_layout(Device& device, bool optimise) {
  Arguments arguments;
  const Buffer out = device.allocate(4 * 14);
  arguments.set("layout_out", out);
  run_once(device, arithmetic_program(device, 1, optimise).kernel("record_layout"), arguments);
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
