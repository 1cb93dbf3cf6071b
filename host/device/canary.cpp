// SPDX-License-Identifier: Apache-2.0
#include "device/canary.h"

#include <array>
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

}  // namespace

Canary::Canary(Device& device, Arguments& arguments) : out_(device.allocate(4 * EK_CANARY_WORDS)) {
  const Contents& in = contents();
  arguments.set("canary_out", out_);
  arguments.set("canary_triangles", device.upload(in.triangles));
  arguments.set("canary_other", device.upload(in.other));
  arguments.set("canary_words", device.upload(in.words));
  arguments.set("canary_floats", device.upload(in.floats));
}

void Canary::require(Device& device) const {
  const std::vector<std::uint32_t> found = device.read_all<std::uint32_t>(out_);
  std::size_t wrong = 0;
  for (std::uint32_t i = 0; i < EK_CANARY_WORDS; ++i) wrong += found[i] != expected_word(i, contents()) ? 1 : 0;
  if (wrong > 0)
    throw UntrustedDevice(fmt::format(
        "device '{}' is not to be trusted: its driver ({} {}) reads memory wrongly ({} of {} words of a probe); choose "
        "another device (--devices), or another driver for it",
        device.info().name, device.info().platform, device.info().driver, wrong, found.size()));
}

void require_canary(Device& device, const Program& program) {
  Arguments arguments;
  const Canary canary(device, arguments);
  Kernel kernel = program.kernel("canary");
  kernel.bind(arguments);
  device.run(kernel, 1, 1);
  canary.require(device);
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

}  // namespace eikon
