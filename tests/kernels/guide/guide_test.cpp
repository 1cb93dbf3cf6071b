// SPDX-License-Identifier: Apache-2.0
// The tables that guide paths: the host makes them, the kernels look them up and sample from them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <numeric>
#include <random>

#include "guide/guide_table.h"
#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "shared/records.h"

namespace eikon::test {
namespace {

Probe guide_probe() { return Probe("guide").append_file("guide/guide_probes.cl"); }

/// One bin that has nearly everything; a slope; weights without order, some 0; no preference.
std::vector<GuideCellData> some_cells() {
  std::mt19937 random(3);
  std::vector<GuideCellData> cells(4);
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].id = i;
  cells[0].target[27] = 1;
  for (std::size_t bin = 0; bin < EK_GUIDE_BINS; ++bin) {
    cells[1].target[bin] = double(bin);
    cells[2].target[bin] = random() % 3 == 0 ? 0 : double(random() % 1000);
  }
  return cells;
}

constexpr std::size_t kSamples = 1 << 19;

enum : unsigned {
#define EK_LOBE(name, bit, traits) kLobe_##name = bit,
#include "shared/features.def"
};

std::vector<Words> warped(const GuideTable& table, std::uint32_t cell) {
  std::mt19937 random(7 + cell);
  Words u, v, cells(kSamples, cell);
  for (std::size_t i = 0; i < kSamples; ++i) {
    u.push_back(as_word(float(random() >> 8) * 0x1p-24F));
    v.push_back(as_word(float(random() >> 8) * 0x1p-24F));
  }
  return guide_probe().buffer("cells", table.cells).run("probe_guide", {u, v, cells}, 8);
}

TEST(Guide, samples_have_the_density_of_the_table) {
  const std::vector<GuideCellData> cells = some_cells();
  const GuideTable table = make_guide_table(cells, 1);
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
    const auto out = warped(table, cell);
    const auto weights = guide_weights(cells[cell].target);
    // Each bin is cut in four, so that samples must be even within it too.
    std::vector<double> observed(4 * EK_GUIDE_BINS, 0), expected(4 * EK_GUIDE_BINS);
    for (std::size_t i = 0; i < expected.size(); ++i)
      expected[i] = double(kSamples) * weights[i / 4] / EK_GUIDE_TOTAL / 4;
    double inverse = 0;
    for (std::size_t i = 0; i < kSamples; ++i) {
      const float x = as_float(out[0][i]) * 8, y = as_float(out[1][i]) * 8;
      ASSERT_TRUE(x >= 0 && x < 8 && y >= 0 && y < 8);
      const auto bin = std::size_t(x) * 8 + std::size_t(y);
      const std::size_t quarter = 2 * std::size_t(x * 2 - 2 * std::floor(x)) + std::size_t(y * 2 - 2 * std::floor(y));
      ++observed[4 * bin + quarter];
      EXPECT_EQ(as_float(out[2][i]), float(weights[bin]) * (64.0F / 65536)) << "the density of bin " << bin;
      EXPECT_GE(as_float(out[2][i]), EK_GUIDE_LEAST);
      inverse += 1 / double(as_float(out[2][i])) / kSamples;
    }
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, sidak(4)) << "cell " << cell << '\n' << test.table;
    EXPECT_NEAR(inverse, 1, 6 * std::sqrt(3.0 / kSamples)) << "the mean weight of a constant";
  }
}

TEST(Guide, the_density_of_a_direction_is_that_of_its_sample) {
  const GuideTable table = make_guide_table(some_cells(), 1);
  for (const std::uint32_t cell : {0U, 2U}) {
    const auto out = warped(table, cell);
    std::size_t differ = 0;
    for (std::size_t i = 0; i < kSamples; ++i) {
      // The inverse map rounds, so a direction at the very edge of a bin may come to lie in the
      // next one.
      const float x = as_float(out[0][i]) * 8, y = as_float(out[1][i]) * 8;
      if (out[7][i] != std::uint32_t(x) * 8 + std::uint32_t(y))
        ++differ;
      else
        EXPECT_EQ(out[2][i], out[6][i]);
    }
    EXPECT_LT(double(differ), 2e-5 * kSamples);
  }
}

// The density of each direction is at least EK_GUIDE_LEAST of what it would be without guiding: the
// diffuse part's is by the least weight of a bin, and the specular part's is the same, or loses the
// sixth that follows the table on rough metal. So what a sample counts for, its f over its pdf, is
// at most 1 / EK_GUIDE_LEAST times what the same direction counts for without guiding.
TEST(Guide, no_weight_grows_by_more_than_the_inverse_of_the_least_density) {
  const GuideTable table = make_guide_table(some_cells(), 1);
  std::mt19937 random(29);
  const auto uniform = [&] { return float(random() >> 8) * 0x1p-24F; };
  std::vector<Words> in(10);
  constexpr std::size_t kTried = 1 << 18;
  for (std::size_t i = 0; i < kTried; ++i) {
    const float z = 0.02F + 0.98F * uniform(), turn = 6.2831853F * uniform(), roughness = uniform();
    const float r = std::sqrt(1 - z * z);
    const bool diffuse = i % 3 == 0;
    std::size_t next = 0;
    for (const std::uint32_t word :
         {std::uint32_t(i % 4), 1U << (diffuse ? kLobe_diffuse : kLobe_metallic_roughness),
          as_word(diffuse ? 0 : uniform()), as_word(roughness * roughness), as_word(r * std::cos(turn)),
          as_word(r * std::sin(turn)), as_word(z), as_word(uniform()), as_word(uniform()), as_word(uniform())})
      in[next++].push_back(word);
  }
  const auto out =
      guide_probe().define("EK_HAS_guiding", "1").buffer("cells", table.cells).run("probe_guided_bsdf", in, 8);
  double most = 0;
  std::size_t grown = 0;
  for (std::size_t i = 0; i < kTried; ++i) {
    const auto at = [&](std::size_t k) { return as_float(out[k][i]); };
    if (out[6][i] != 0 || at(1) <= 0) continue;
    EXPECT_NEAR(at(3), at(1), 2e-3F * at(1)) << "the density of a sample is that of its direction";
    EXPECT_EQ(at(2), at(4)) << "guiding changes no f";
    EXPECT_GE(at(3), EK_GUIDE_LEAST * at(5) * 0.9999F) << i;
    const double growth = double(at(0)) / (double(at(4)) / double(at(5)));
    EXPECT_LE(growth, 1 / double(EK_GUIDE_LEAST) * 1.01) << i;
    most = std::max(most, growth);
    grown += growth > 2 ? 1 : 0;
  }
  EXPECT_GT(most, 3.9) << "the bound is never met: the test sees nothing";
  EXPECT_GT(grown, kTried / 100);
}

/// A rough surface with a table, and a viewer.
struct GuidedSurface {
  std::uint32_t cell;
  float metallic, roughness, cosine;

  /// The inputs of the probes that are the same for all directions.
  [[nodiscard]] std::vector<Words> inputs(std::size_t count) const {
    const float sine = std::sqrt(1 - cosine * cosine);
    std::vector<Words> in;
    for (const std::uint32_t word :
         {cell, 1U << kLobe_metallic_roughness, as_word(metallic), as_word(roughness * roughness), as_word(0.6F * sine),
          as_word(0.8F * sine), as_word(cosine)})
      in.emplace_back(count, word);
    return in;
  }
};

/// The probability of each bin: a sum over a grid that is even in solid angle between the circles
/// on which bins end. By the cosine, the density at grazing directions would have no bound.
std::vector<double> bin_probabilities(const GuidedSurface& surface, const GuideTable& table) {
  constexpr std::size_t kRings = EK_GUIDE_ROWS / 2, kHeights = 256, kTurns = 1024;
  std::vector<Words> in = surface.inputs(kRings * kHeights * kTurns);
  Words x, y, z;
  std::vector<double> solid_angle;
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    const auto circle = [](std::size_t at) { return std::sqrt(1 - std::pow(double(at) / kRings, 2)); };
    const double step = (circle(ring) - circle(ring + 1)) / kHeights;
    for (std::size_t i = 0; i < kHeights * kTurns; ++i) {
      const double height = circle(ring) - (double(i / kTurns) + 0.5) * step, radius = std::sqrt(1 - height * height);
      const double turn = 2 * std::numbers::pi * (double(i % kTurns) + 0.5) / kTurns;
      x.push_back(as_word(float(radius * std::cos(turn))));
      y.push_back(as_word(float(radius * std::sin(turn))));
      z.push_back(as_word(float(height)));
      solid_angle.push_back(step * 2 * std::numbers::pi / kTurns);
    }
  }
  in.insert(in.end(), {x, y, z});
  const auto out =
      guide_probe().define("EK_HAS_guiding", "1").buffer("cells", table.cells).run("probe_guided_pdf", in, 2);
  std::vector<double> shares(EK_GUIDE_BINS, 0);
  for (std::size_t i = 0; i < solid_angle.size(); ++i)
    shares[out[1][i]] += double(as_float(out[0][i])) * solid_angle[i];
  return shares;
}

TEST(Guide, samples_of_rough_surfaces_have_the_density_that_they_state) {
  const GuideTable table = make_guide_table(some_cells(), 1);
  const std::vector<GuidedSurface> surfaces = {{0, 1, 0.5F, 0.8F},  {2, 1, 0.5F, 0.3F}, {0, 1, 0.9F, 0.5F},
                                               {2, 0, 0.45F, 0.7F}, {1, 1, 0.3F, 0.8F}, {0, 0.6F, 0.6F, 0.2F}};
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    std::mt19937 random(31 + unsigned(k));
    std::vector<Words> in = surfaces[k].inputs(kSamples);
    for (int i = 0; i < 3; ++i) {
      Words& numbers = in.emplace_back();
      for (std::size_t n = 0; n < kSamples; ++n) numbers.push_back(as_word(float(random() >> 8) * 0x1p-24F));
    }
    const auto out =
        guide_probe().define("EK_HAS_guiding", "1").buffer("cells", table.cells).run("probe_guided_bsdf", in, 8);
    // The last entry counts what is reflected into the surface.
    std::vector<double> observed(EK_GUIDE_BINS + 1, 0), expected = bin_probabilities(surfaces[k], table);
    for (std::size_t n = 0; n < kSamples; ++n) ++observed[as_float(out[1][n]) > 0 ? out[7][n] : EK_GUIDE_BINS];
    expected.push_back(1 - std::accumulate(expected.begin(), expected.end(), 0.0));
    for (double& share : expected) share *= double(kSamples);
    const ChiSquare test = chi_square(observed, expected);
    EXPECT_GT(test.p_value, sidak(surfaces.size())) << "surface " << k << '\n' << test.table;
  }
}

TEST(Guide, lanes_without_a_cell_keep_their_samples) {
  const GuideTable table = make_guide_table(some_cells(), 1);
  const Words u(64, as_word(0.3F)), v(64, as_word(0.7F)), none(64, 0xffffffffU);
  const auto out = guide_probe().buffer("cells", table.cells).run("probe_guide", {u, v, none}, 8);
  EXPECT_EQ(out[0], u);
  EXPECT_EQ(out[1], v);
  EXPECT_EQ(out[2], Words(64, as_word(1.0F)));
  EXPECT_EQ(out[6], Words(64, as_word(1.0F)));
}

TEST(Guide, a_point_finds_its_cell_or_the_one_around_it) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(-20, 20), turn(-1, 1);
  std::vector<Words> in(6);
  constexpr std::size_t kPoints = 4096;
  for (std::size_t i = 0; i < kPoints; ++i) {
    for (std::size_t k = 0; k < 3; ++k) in[k].push_back(as_word(place(random)));
    glm::vec3 n(turn(random), turn(random), turn(random));
    n = i % 4 == 0 ? glm::vec3(0, i % 8 == 0 ? 1 : -1, 0) : glm::normalize(n);
    for (std::size_t k = 0; k < 3; ++k) in[3 + k].push_back(as_word(n[int(k)]));
  }
  Frame frame{};
  frame.guide_scale = 2;
  const auto keys =
      guide_probe().buffer("frame", std::vector<Frame>{frame}).buffer("slots", Words(2, 0)).run("probe_cells", in, 3);
  EXPECT_EQ(keys[2], Words(kPoints, 0xffffffffU)) << "an empty table has no cell";
  // A third of the points have a cell of level 0, a third one of level 1, the others none.
  std::vector<CellId> ids;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const CellId id = cell_id(keys[0][i], keys[1][i]);
    if (i % 3 == 0) ids.push_back(id);
    if (i % 3 == 1) ids.push_back(coarser(id));
  }
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  std::vector<GuideCellData> cells;
  for (const CellId id : ids) cells.push_back({.id = id});
  const GuideTable table = make_guide_table(cells, 2);
  frame.guide_slot_mask = table.slot_mask();
  const auto found =
      guide_probe().buffer("frame", std::vector<Frame>{frame}).buffer("slots", table.slots).run("probe_cells", in, 3);
  for (std::size_t i = 0; i < kPoints; ++i) {
    CellId id = cell_id(keys[0][i], keys[1][i]);
    std::uint32_t expected = 0xffffffffU;
    for (std::uint32_t level = 0; level < EK_GUIDE_LEVELS && expected == 0xffffffffU; ++level, id = coarser(id))
      if (const auto at = std::ranges::lower_bound(ids, id); at != ids.end() && *at == id)
        expected = std::uint32_t(at - ids.begin());
    EXPECT_EQ(found[2][i], expected) << i;
  }
}

}  // namespace
}  // namespace eikon::test
