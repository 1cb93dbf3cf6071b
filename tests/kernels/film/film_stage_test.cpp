// SPDX-License-Identifier: Apache-2.0
// Stage `film` as the renderer compiles it, fed with film slots of our own; the host's to_fixed is
// the oracle.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "device/device.h"
#include "device/kernel_sources.h"
#include "pack/features.h"
#include "film/film.h"
#include "film/packed_sums.h"
#include "shared/records.h"
#include "support/fixed_point.h"

namespace eikon {
namespace {

constexpr std::uint32_t kChannels = 3;

struct Shape {
  std::uint32_t lanes;
  bool chunked;
};
const Shape kShapes[] = {{16, true}, {8, true}, {1, true}, {1, false}};

struct Unit {
  std::uint32_t pixels = 0, samples = 0, sample_begin = 0, replicate_bits = 1;
  std::vector<float> slots;  // [channel][sample][pixel]
  [[nodiscard]] float& at(std::uint32_t channel, std::uint32_t sample, std::uint32_t pixel) {
    return slots[(std::size_t{channel} * samples + sample) * pixels + pixel];
  }
};

struct Sums {
  std::vector<std::uint32_t> limbs, rejected;
  std::vector<std::uint32_t> packed;  // empty on chunks
  Diagnostics diagnostics;
  std::uint32_t stride = 0;
  [[nodiscard]] int128 sum(std::uint32_t replicate, std::uint32_t channel, std::uint32_t pixel) const {
    unsigned __int128 value = 0;
    for (std::uint32_t limb = EK_FILM_LIMBS; limb-- > 0;)
      value =
          value << 32 | limbs[((std::size_t{replicate} * kChannels + channel) * EK_FILM_LIMBS + limb) * stride + pixel];
    return static_cast<int128>(value);
  }
};

Sums run_film(const DeviceInfo& info, const Shape& shape, Unit& unit) {
  Device device(info);
  ProgramOptions options;
  options.defines = Features(Scene{}, Settings{}).defines();
  options.defines["EK_WIDTH"] = std::to_string(shape.lanes);
  options.defines["EK_CHUNKED"] = shape.chunked ? "1" : "0";
  options.defines["EK_CHUNK"] = "1024";
  Frame frame{};
  frame.pixel_count = unit.pixels;
  frame.sample_count = unit.samples;
  frame.sample_begin = unit.sample_begin;
  frame.replicate_bits = unit.replicate_bits;
  frame.path_count = unit.pixels * unit.samples;
  frame.film_stride = frame.path_count + 16;
  frame.pixel_stride = (unit.pixels + 31) / 16 * 16;
  std::vector<float> slots(std::size_t{frame.film_stride} * kChannels + 16);
  for (std::uint32_t c = 0; c < kChannels; ++c)
    for (std::uint32_t i = 0; i < frame.path_count; ++i)
      slots[std::size_t{c} * frame.film_stride + i] = unit.slots[std::size_t{c} * frame.path_count + i];

  Sums sums;
  sums.stride = frame.pixel_stride;
  const std::uint32_t replicates = 1U << unit.replicate_bits;
  sums.limbs.resize(std::size_t{replicates} * kChannels * EK_FILM_LIMBS * sums.stride);
  sums.rejected.resize(std::size_t{replicates} * sums.stride);
  Arguments arguments;
  arguments.set("frame", device.upload(&frame, sizeof frame));
  arguments.set("film_slots", device.upload(slots));
  const Buffer limbs = device.upload(sums.limbs), rejected = device.upload(sums.rejected);
  const Buffer diagnostics = device.upload(std::vector<std::uint32_t>(sizeof(Diagnostics) / 4));
  arguments.set("film_sums", limbs);
  arguments.set("film_rejected", rejected);
  arguments.set("diagnostics", diagnostics);
  const Program program = device.build(kernel_text({"stages/film.cl", "stages/pack_sums.cl"}), options);
  Kernel kernel = program.kernel("film");
  kernel.bind(arguments);
  device.run(kernel, (unit.pixels + 63) / 64, shape.chunked ? 1 : 64);
  if (!shape.chunked) {
    sums.packed.resize(packed_words(std::size_t{replicates} * kChannels, sums.stride));
    const Buffer packed = device.upload(sums.packed);
    arguments.set("film_packed", packed);
    Kernel packs = program.kernel("pack_sums");
    packs.bind(arguments);
    device.run(packs, (unit.pixels + 63) / 64, 64);
    device.read(packed, sums.packed.data(), 4 * sums.packed.size());
  }
  device.read(limbs, sums.limbs.data(), 4 * sums.limbs.size());
  device.read(rejected, sums.rejected.data(), 4 * sums.rejected.size());
  device.read(diagnostics, &sums.diagnostics, sizeof sums.diagnostics);
  return sums;
}

Unit random_unit(std::uint32_t pixels, std::uint32_t samples, std::uint32_t begin, std::uint32_t replicate_bits,
                 std::uint32_t seed) {
  Unit unit{pixels, samples, begin, replicate_bits, {}};
  std::mt19937 random(seed);
  // Every exponent that a film can hold and smaller ones, both signs, zeros and denormals among
  // them.
  for (std::size_t i = 0; i < std::size_t{kChannels} * pixels * samples; ++i) {
    const auto exponent = std::uint32_t(random() % 165);
    unit.slots.push_back(std::bit_cast<float>(std::uint32_t(random() & 0x807fffffU) | (exponent << 23)));
    if (random() % 16 == 0) unit.slots.back() = random() % 2 == 0 ? 0.0F : -0.0F;
  }
  return unit;
}

void expect_exact(const Sums& sums, Unit& unit) {
  const std::uint32_t replicates = 1U << unit.replicate_bits;
  for (std::uint32_t pixel = 0; pixel < unit.pixels; ++pixel)
    for (std::uint32_t replicate = 0; replicate < replicates; ++replicate)
      for (std::uint32_t c = 0; c < kChannels; ++c) {
        int128 expected = 0;
        for (std::uint32_t s = 0; s < unit.samples; ++s)
          if ((unit.sample_begin + s) % replicates == replicate) expected += to_fixed(unit.at(c, s, pixel));
        ASSERT_TRUE(sums.sum(replicate, c, pixel) == expected)
            << "pixel " << pixel << " replicate " << replicate << " channel " << c;
      }
}

TEST(FilmStage, sums_are_those_of_exact_integers_at_every_width) {
  for (const DeviceInfo& info : select_devices("all"))
    for (const Shape& shape : kShapes)
      for (auto [pixels, samples, begin, bits] :
           {std::array{1U, 1U, 0U, 1U}, {70U, 5U, 3U, 1U}, {130U, 16U, 7U, 2U}, {33U, 9U, 0U, 0U}}) {
        SCOPED_TRACE(testing::Message() << info.name << " lanes " << shape.lanes << " chunked " << shape.chunked
                                        << " pixels " << pixels);
        Unit unit = random_unit(pixels, samples, begin, bits, 17 + pixels);
        const Sums sums = run_film(info, shape, unit);
        expect_exact(sums, unit);
        EXPECT_EQ(sums.diagnostics.reported, 0U);
      }
}

/// Checks the packed sums against the others. returns  those that fit
std::uint32_t expect_packed(const Sums& sums, const Unit& unit) {
  const std::uint32_t replicates = 1U << unit.replicate_bits, all = replicates * kChannels;
  std::uint32_t fit = 0;
  for (std::uint32_t pixel = 0; pixel < unit.pixels; ++pixel)
    for (std::uint32_t k = 0; k < all; ++k) {
      const std::optional<PackedSum> expected = packed_sum(sums.sum(k / kChannels, k % kChannels, pixel));
      if (!expected) continue;
      ++fit;
      const std::uint32_t* const at = &sums.packed[EK_PACKED_HEAD + pixel];
      const std::uint64_t low = at[2 * k * sums.stride], high = at[(2 * k + 1) * sums.stride];
      EXPECT_EQ(std::int64_t(low | high << 32), expected->number) << pixel << " " << k;
      EXPECT_EQ(at[(2 * all + k / 4) * sums.stride] >> 8 * (k % 4) & 0xffU, expected->shift) << pixel << " " << k;
    }
  EXPECT_EQ(sums.packed[0], unit.pixels * all - fit) << "those that do not fit are counted";
  return fit;
}

TEST(FilmStage, packed_sums_are_the_sums_or_are_counted) {
  for (const DeviceInfo& info : select_devices("all")) {
    Unit unit = random_unit(70, 12, 3, 1, 9);
    const Sums any = run_film(info, {1, false}, unit);
    const std::uint32_t fit = expect_packed(any, unit);
    EXPECT_GT(fit, 0U);
    EXPECT_LT(fit, unit.pixels * 2 * kChannels);
    // Samples of 2^-40 to 2^-4, of both signs.
    for (std::size_t i = 0; i < unit.slots.size(); ++i) {
      const std::uint32_t mantissa = std::bit_cast<std::uint32_t>(unit.slots[i]) & 0x807fffffU;
      unit.slots[i] = std::bit_cast<float>(mantissa | (87U + std::uint32_t(i) % 36) << 23);
    }
    const Sums usual = run_film(info, {1, false}, unit);
    EXPECT_EQ(expect_packed(usual, unit), unit.pixels * 2 * kChannels);
  }
}

TEST(FilmStage, N12_a_sample_that_is_not_finite_or_too_large_is_left_out_whole_counted_and_reported) {
  const float inf = std::numeric_limits<float>::infinity();
  for (const DeviceInfo& info : select_devices("all"))
    for (const Shape& shape : kShapes) {
      SCOPED_TRACE(testing::Message() << info.name << " lanes " << shape.lanes << " chunked " << shape.chunked);
      Unit unit = random_unit(70, 6, 1, 1, 5);
      Unit bad = unit;
      struct {
        std::uint32_t channel, sample, pixel;
        float value;
      } const injected[] = {{1, 4, 3, std::numeric_limits<float>::quiet_NaN()},
                            {0, 0, 69, inf},
                            {2, 5, 17, -inf},
                            {2, 2, 40, 0x1p38F},
                            {0, 1, 41, -0x1p100F}};
      for (const auto& i : injected) {
        bad.at(i.channel, i.sample, i.pixel) = i.value;
        for (std::uint32_t c = 0; c < kChannels; ++c)
          unit.at(c, i.sample, i.pixel) = 0;  // what the film should have seen
      }
      const Sums sums = run_film(info, shape, bad);
      expect_exact(sums, unit);
      EXPECT_EQ(sums.diagnostics.nonfinite, 3U);
      EXPECT_EQ(sums.diagnostics.saturated, 2U);
      ASSERT_EQ(sums.diagnostics.reported, 5U);
      for (const auto& i : injected) {
        EXPECT_EQ(sums.rejected[((1 + i.sample) % 2) * sums.stride + i.pixel], 1U);
        bool reported = false;
        for (std::uint32_t k = 0; k < 5; ++k)
          reported =
              reported || (sums.diagnostics.report[2 * k] == i.pixel && sums.diagnostics.report[2 * k + 1] == i.sample);
        EXPECT_TRUE(reported) << "pixel " << i.pixel << " sample " << i.sample;
      }
      std::uint32_t rejected = 0;
      for (std::uint32_t count : sums.rejected) rejected += count;
      EXPECT_EQ(rejected, 5U);
    }
}

}  // namespace
}  // namespace eikon
