// SPDX-License-Identifier: Apache-2.0
// Measured tables: Lambert's, interpolation, reciprocity, sampling, energy, and known materials.
#include <gtest/gtest.h>

#include <functional>

#include "kernels/bsdf/bsdf_probe.h"
#include "kernels/statistics.h"
#include "scene/measured_table.h"
#include "support/measured_material.h"

namespace eikon::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kH = EK_MEASURED_THETA_H, kD = EK_MEASURED_THETA_D, kP = EK_MEASURED_PHI_D;

/// Coordinates of a pair of directions, in cells: i is the lower bound of cell i.
struct Angles {
  double h, d, p, cos_d;
};
Angles angles_of(const std::array<double, 3>& wo, const std::array<double, 3>& wi) {
  std::array<double, 3> sum{}, half{}, along{};
  double length2 = 0;
  for (std::size_t k = 0; k < 3; ++k) sum[k] = wo[k] + wi[k];
  for (const double x : sum) length2 += x * x;
  for (std::size_t k = 0; k < 3; ++k) half[k] = sum[k] / std::sqrt(length2);
  const double sin_h = std::hypot(half[0], half[1]), cos_d = std::sqrt(length2) / 2;
  // MERL's frame: the half vector is turned to the pole, about the normal and the second axis.
  const double c = half[0] / sin_h, s = half[1] / sin_h;
  along = {c * wi[0] + s * wi[1], -s * wi[0] + c * wi[1], wi[2]};
  const double x = half[2] * along[0] - sin_h * along[2], y = along[1];
  double phi = std::atan2(y, x);
  if (phi < 0) phi += kPi;
  return {kH * std::sqrt(std::atan2(sin_h, half[2]) / (kPi / 2)), std::acos(std::min(1.0, cos_d)) / (kPi / 2) * kD,
          phi / kPi * kP, cos_d};
}
std::array<double, 3> direction(const Queries& q, std::size_t i, std::size_t first) {
  return {as_float(q.in[first][i]), as_float(q.in[first + 1][i]), as_float(q.in[first + 2][i])};
}

/// A table whose entries are f(h, d, p, channel) of the cells' numbers.
std::vector<float> table_of(const std::function<double(int, int, int, int)>& f) {
  std::vector<float> rgb;
  for (int h = 0; h < kH; ++h)
    for (int d = 0; d < kD; ++d)
      for (int p = 0; p < kP; ++p)
        for (int c = 0; c < 3; ++c) rgb.push_back(float(f(h, d, p, c)));
  return rgb;
}
/// Density of GGX's microfacets at the middle of a cell of theta_h.
double ggx(int h, double alpha) {
  const double share = (h + 0.5) / kH, cosine = std::cos(share * share * kPi / 2), sine2 = 1 - cosine * cosine;
  const double q = cosine * cosine + sine2 / (alpha * alpha);
  return 1 / (kPi * alpha * alpha * q * q);
}
std::vector<float> metal_table(double alpha) {
  return table_of([=](int h, int, int, int c) { return 0.2 * (1 + 0.3 * c) * ggx(h, alpha); });
}
std::vector<float> plastic_table() {
  return table_of([](int h, int d, int, int c) { return 0.15 / (1 + c) + 0.01 * (1 + d / 30.0) * ggx(h, 0.1); });
}
/// Neither symmetric nor smooth.
std::vector<float> uneven_table() {
  return table_of([](int h, int d, int p, int c) { return 0.2 + 0.1 * std::sin(0.3 * h + 0.2 * d + 0.4 * p + c); });
}

Answers scatter(const MeasuredTable& table, const Queries& q, const std::array<float, 3>& color = {1, 1, 1}) {
  MaterialRecord m{};
  m.flags = 1U << kLobe_measured;
  m.base_color_r = color[0], m.base_color_g = color[1], m.base_color_b = color[2];
  m.opacity = 1;
  m.base_color_texture = m.metallic_roughness_texture = m.normal_texture = m.emissive_texture = EK_NO_TEXTURE;
  MaterialExtension e{};
  e.transmission_texture = e.specular_texture = e.specular_color_texture = EK_NO_TEXTURE;
  e.measured_table = EK_TEXEL_TABLE;
  MaterialDetail d{};
  d.clearcoat_texture = d.clearcoat_roughness_texture = d.clearcoat_normal_texture = EK_NO_TEXTURE;
  d.sheen_color_texture = d.sheen_roughness_texture = d.anisotropy_texture = EK_NO_TEXTURE;
  d.diffuse_transmission_texture = d.diffuse_transmission_color_texture = EK_NO_TEXTURE;
  Words texels(EK_TEXEL_TABLE);
  texels.insert(texels.end(), table.words.begin(), table.words.end());
  return {scatter({m}, {e}, {d}, q, false, false, texels)};
}

TEST(MeasuredLobe, M23_a_table_of_rho_over_pi_is_lambert_within_rounding) {
  const double rho[3] = {0.8, 0.3, 0.05};
  std::vector<float> rgb = table_of([&](int, int, int, int c) { return rho[c] / kPi; });
  // What no pair of directions above the surface has is not read.
  for (int h = 0; h < kH; ++h)
    for (int d = 0; d < kD; ++d)
      for (int p = 0; p < kP; ++p) {
        const double th = std::pow((h + 0.5) / kH, 2) * kPi / 2, td = (d + 0.5) / kD * kPi / 2,
                     pd = (p + 0.5) / kP * kPi;
        if (std::cos(td) * std::cos(th) <= std::abs(std::cos(pd)) * std::sin(td) * std::sin(th))
          for (int c = 0; c < 3; ++c) rgb[std::size_t(3 * ((h * kD + d) * kP + p) + c)] = -1;
      }
  const MeasuredTable table = make_measured_table(std::move(rgb));
  EXPECT_EQ(table.holes, 0U);
  std::mt19937 random(1);
  Queries q;
  for (int i = 0; i < 100000; ++i) {
    const Direction wo = from_cosine(1 - uniform(random), uniform(random));
    q.add(0, wo, from_cosine(1 - uniform(random), uniform(random)), uniform(random), uniform(random), uniform(random));
  }
  const Answers answers = scatter(table, q);
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double cosine = as_float(q.in[6][i]);
    const Sampled s = answers.sample(i);
    for (std::size_t c = 0; c < 3; ++c) {
      // Three roundings: of rho / pi, of the product with the cosine, of the colour's.
      ASSERT_NEAR(answers.eval(i, c), rho[c] / kPi * cosine, 2e-7 * rho[c] * cosine);
      ASSERT_NEAR(s.weight[c], rho[c], 4e-7 * rho[c]);
    }
    ASSERT_NEAR(answers.pdf(i), cosine / kPi, 2e-7 * cosine);
  }
}

TEST(MeasuredLobe, M2_exchanging_the_directions_changes_no_more_than_the_last_bits) {
  const MeasuredTable table = make_measured_table(uneven_table());
  std::mt19937 random(2);
  Queries there, back;
  for (int i = 0; i < 100000; ++i) {
    // Some pairs in one plane with the normal, some of equal angle, some both.
    const double z = 1 - uniform(random), turn = uniform(random);
    const Direction wo = from_cosine(z, turn),
                    wi = from_cosine(i % 3 == 0 ? z : 1 - uniform(random), i % 5 == 0 ? turn + 0.5 : uniform(random));
    there.add(0, wo, wi, 0, 0, 0);
    back.add(0, wi, wo, 0, 0, 0);
  }
  const Answers a = scatter(table, there), b = scatter(table, back);
  for (std::size_t i = 0; i < there.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double f = a.eval(i, c) / as_float(there.in[6][i]), g = b.eval(i, c) / as_float(back.in[6][i]);
      ASSERT_NEAR(f, g, 1.3e-7 * f);  // f is the same number; each product with a cosine is rounded once, by 2^-24
    }
}

TEST(MeasuredLobe, values_between_the_middles_of_cells_are_interpolated_and_phi_d_begins_again) {
  const std::vector<float> rgb = uneven_table();
  const MeasuredTable table = make_measured_table(rgb);
  std::mt19937 random(3);
  Queries q;
  for (int i = 0; i < 100000; ++i)
    q.add(0, from_cosine(0.2 + 0.8 * uniform(random), uniform(random)),
          from_cosine(0.2 + 0.8 * uniform(random), uniform(random)), 0, 0, 0);
  const Answers answers = scatter(table, q, {0.5F, 1, 1});
  std::size_t compared = 0, wrapped = 0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Angles at = angles_of(direction(q, i, 1), direction(q, i, 4));
    const double theta_h = at.h * at.h / kH / kH * kPi / 2, theta_d = at.d / kD * kPi / 2;
    // Directions are rounded by 6e-8, which turns phi_d by as much over sin theta_h sin theta_d.
    if (std::min(std::sin(theta_h), std::sin(theta_d)) < 0.1 || at.h > kH - 1 || at.d > kD - 1) continue;
    const double h = at.h - 0.5, d = at.d - 0.5, p = at.p - 0.5 < 0 ? at.p - 0.5 + kP : at.p - 0.5;
    const int h0 = int(h), d0 = int(d), p0 = int(p);
    // All eight above the surface, where entries are the file's own.
    const double th = std::pow((h0 + 1.5) / kH, 2) * kPi / 2, td = (d0 + 1.5) / kD * kPi / 2;
    if (std::cos(td) * std::cos(th) <= std::sin(td) * std::sin(th)) continue;
    double expected[3] = {0, 0, 0};
    for (int corner = 0; corner < 8; ++corner) {
      const int dh = corner & 1, dd = corner >> 1 & 1, dp = corner >> 2;
      const double w =
          (dh != 0 ? h - h0 : 1 - h + h0) * (dd != 0 ? d - d0 : 1 - d + d0) * (dp != 0 ? p - p0 : 1 - p + p0);
      const int cell = ((h0 + dh) * kD + d0 + dd) * kP + (p0 + dp) % kP;
      for (int c = 0; c < 3; ++c) expected[c] += w * double(rgb[std::size_t(3 * cell + c)]);
    }
    ++compared;
    wrapped += p0 == kP - 1 ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double f = answers.eval(i, c) / as_float(q.in[6][i]);
      // phi_d is off by 1e-7 / 0.01 rad at most, 1e-3 cells; values change by 0.04 per cell.
      ASSERT_NEAR(f, (c == 0 ? 0.5 : 1) * expected[c], 5e-5) << at.h << " " << at.d << " " << at.p;
    }
  }
  EXPECT_GT(compared, 20000U);
  EXPECT_GT(wrapped, 50U);
}

TEST(MeasuredLobe, M23_entries_without_a_measurement_reflect_nothing) {
  std::vector<float> rgb = table_of([](int, int, int, int) { return -1; });
  const MeasuredTable black = make_measured_table(rgb);
  std::mt19937 random(4);
  Queries q;
  for (int i = 0; i < 20000; ++i)
    q.add(0, from_cosine(1 - uniform(random), uniform(random)), from_cosine(1 - uniform(random), uniform(random)),
          uniform(random), uniform(random), uniform(random));
  const Answers answers = scatter(black, q);
  for (std::size_t i = 0; i < q.size(); ++i) {
    ASSERT_EQ(answers.eval(i, 0), 0);
    ASSERT_EQ(answers.sample(i).weight[1], 0);
  }
}

TEST(MeasuredLobe, M1_weight_is_eval_over_pdf_and_bounded) {
  for (const auto& rgb : {metal_table(0.02), plastic_table(), uneven_table()}) {
    const float most = *std::ranges::max_element(rgb);
    const MeasuredTable table = make_measured_table(rgb);
    std::mt19937 random(5);
    Queries q;
    for (int i = 0; i < 1 << 16; ++i) q.add(0, from_cosine(1 - uniform(random), uniform(random)), random);
    const Answers answers = scatter(table, q);
    for (std::size_t i = 0; i < q.size(); ++i) {
      const Sampled s = answers.sample(i);
      if (s.pdf == 0) continue;
      ASSERT_NEAR(s.wi[0] * s.wi[0] + s.wi[1] * s.wi[1] + s.wi[2] * s.wi[2], 1, 1e-6);
      ASSERT_FALSE(s.delta);
      ASSERT_EQ(s.pdf_again, s.pdf);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(s.weight[c] * s.pdf, s.eval[c], 1e-6 * s.eval[c] + 1e-30);
        ASSERT_LE(s.weight[c], 8 * kPi * double(most) * (1 + 1e-5));
      }
    }
  }
}

/// Half vectors above the surface by theta_h's cells and sectors about the normal.
constexpr int kSectors = 12;

TEST(MeasuredLobe, M1_samples_have_the_density_that_pdf_states) {
  constexpr unsigned kSamples = 100000;
  const std::vector<std::vector<float>> tables{metal_table(0.01), metal_table(0.3), plastic_table(), uneven_table()};
  const double angles[] = {0, 45, 80, 89};
  const double significance = sidak(tables.size() * std::size(angles));
  for (std::size_t which = 0; which < tables.size(); ++which) {
    const MeasuredTable table = make_measured_table(tables[which]);
    for (const double angle : angles) {
      SCOPED_TRACE("table " + std::to_string(which) + ", " + std::to_string(angle) + " degrees");
      std::mt19937 random(6);
      const Direction wo = from_angle(angle, 0);
      Queries q;
      q.draw(kSamples, 0, wo, random);
      const Answers sampled = scatter(table, q);
      std::vector<double> observed(std::size_t{kH} * kSectors, 0), expected(observed.size(), 0);
      const auto bin = [](const std::array<double, 3>& h) {
        const double share = std::sqrt(std::atan2(std::hypot(h[0], h[1]), h[2]) / (kPi / 2));
        const int sector = int((std::atan2(h[1], h[0]) / (2 * kPi) + 0.5) * kSectors);
        return std::size_t(std::min(int(share * kH), kH - 1) * kSectors + std::min(sector, kSectors - 1));
      };
      double scattered = 0;
      for (unsigned i = 0; i < kSamples; ++i) {
        const Sampled s = sampled.sample(i);
        if (s.pdf == 0) continue;
        ++scattered;
        ++observed[bin({wo[0] + s.wi[0], wo[1] + s.wi[1], wo[2] + s.wi[2]})];
      }
      // By the midpoint rule: densities are constant over a cell, times smooth factors.
      constexpr int kSteps = 16;
      Queries grid;
      std::vector<std::size_t> bins;
      std::vector<double> measures;
      for (int i = 0; i < kH; ++i) {
        const auto versine = [](double cell) { return 2 * std::pow(std::sin(cell * cell / kH / kH * kPi / 4), 2); };
        const double inner = versine(i), width = (versine(i + 1) - inner) / kSteps;
        for (int a = 0; a < kSteps; ++a) {
          const double v = inner + (a + 0.5) * width, r = std::sqrt(v * (2 - v)), z = 1 - v, x_o = wo[0], z_o = wo[2];
          // wi is above the surface for half vectors whose azimuth is below this one.
          const double cut = std::acos(std::clamp((z_o / (2 * z) - z * z_o) / std::max(r * x_o, 1e-30), -1.0, 1.0));
          for (int sector = 0; sector < kSectors; ++sector) {
            const double lo = std::max((sector / double(kSectors) - 0.5) * 2 * kPi, -cut),
                         hi = std::min(((sector + 1) / double(kSectors) - 0.5) * 2 * kPi, cut);
            for (int b = 0; b < kSteps && lo < hi; ++b) {
              const double phi = lo + (b + 0.5) / kSteps * (hi - lo);
              const std::array<double, 3> h{r * std::cos(phi), r * std::sin(phi), z};
              const double cos_d = x_o * h[0] + z_o * z, up = 2 * cos_d * z - z_o;
              if (!(up > 0)) continue;
              grid.add(0, wo, {float(2 * cos_d * h[0] - x_o), float(2 * cos_d * h[1]), float(up)}, 0, 0, 0);
              bins.push_back(std::size_t(i * kSectors + sector));
              measures.push_back(4 * cos_d * width * (hi - lo) / kSteps);
            }
          }
        }
      }
      const Answers stated = scatter(table, grid);
      double total = 0;
      for (std::size_t i = 0; i < bins.size(); ++i) {
        expected[bins[i]] += stated.pdf(i) * measures[i];
        total += stated.pdf(i) * measures[i];
      }
      EXPECT_LE(total, 1 + 1e-3);
      EXPECT_NEAR(total, scattered / kSamples, 4.5 * std::sqrt(std::max(total * (1 - total), 0.0) / kSamples) + 2e-3);
      for (double& share : expected) share *= scattered / total;
      const ChiSquare test = chi_square(observed, expected);
      EXPECT_GT(test.p_value, significance) << test.statistic << " of " << test.degrees;
    }
  }
}

double relative_spread(const Mean& m, std::size_t count) {
  return m.standard_error * std::sqrt(double(count)) / m.mean;
}

TEST(MeasuredLobe, M5_samples_reflect_what_the_table_does_with_less_noise_than_the_cosines) {
  const MeasuredTable metal = make_measured_table(metal_table(0.05)), plastic = make_measured_table(plastic_table());
  for (const MeasuredTable* table : {&metal, &plastic})
    for (const std::size_t view : {std::size_t{31}, std::size_t{20}, std::size_t{8}, std::size_t{2}}) {
      std::mt19937 random(7);
      const double z = MeasuredTable::cosine(view);
      Queries q;
      for (int i = 0; i < 100000; ++i)
        q.add(0, from_cosine(z, uniform(random)), from_cosine(std::sqrt(1 - uniform(random)), uniform(random)),
              uniform(random), uniform(random), uniform(random));
      const Answers answers = scatter(*table, q);
      std::vector<double> weights, by_cosine;
      for (std::size_t i = 0; i < q.size(); ++i) {
        const Sampled s = answers.sample(i);
        weights.push_back(s.pdf > 0 ? s.weight[1] : 0);
        by_cosine.push_back(answers.eval(i, 1) * kPi / as_float(q.in[6][i]));
      }
      const Mean mean = mean_of(weights), wide = mean_of(by_cosine);
      const double albedo = table->albedos[view].y;
      EXPECT_NEAR(mean.mean, albedo, 0.01 * albedo + 4 * mean.standard_error) << z;
      EXPECT_NEAR(wide.mean, albedo, 0.01 * albedo + 4 * wide.standard_error) << z;
      const double spread = relative_spread(mean, q.size()), cosine = relative_spread(wide, q.size());
      std::printf("%s, cosine %.2f: albedo %.4f; weights spread by %.2f of it, by the cosine's %.2f\n",
                  table == &metal ? "metal" : "plastic", z, mean.mean, spread, cosine);
      EXPECT_LT(spread, table == &metal ? 0.25 * cosine : cosine);
    }
}

/// A material as a file has it and as the probe has it.
struct Known {
  const char* name;
  Material material;
  Specimen specimen;
};
std::vector<Known> known_materials() {
  Known lambert{"Lambert", {}, {"", kLobe_diffuse, {.base_color = {0.8F, 0.5F, 0.2F}}}};
  lambert.material.base_color = {0.8F, 0.5F, 0.2F};
  lambert.material.metallic = lambert.material.specular = 0;
  Known copper{"rough copper", {}, {"", kLobe_conductor, {.metallic = 1, .roughness = 0.35F}}};
  copper.material.roughness = 0.35F;
  copper.material.lobe = Lobe::conductor;
  copper.material.conductor_eta = {0.216561F, 0.958162F, 1.165808F};
  copper.material.conductor_k = {3.637741F, 2.577065F, 2.393857F};
  copper.specimen.material.eta = {0.216561F, 0.958162F, 1.165808F};
  copper.specimen.material.k = {3.637741F, 2.577065F, 2.393857F};
  Known plastic{"plastic", {}, {"", kLobe_metallic_roughness, {.base_color = {0.7F, 0.3F, 0.1F}, .roughness = 0.4F}}};
  plastic.material.base_color = {0.7F, 0.3F, 0.1F};
  plastic.material.metallic = 0;
  plastic.material.roughness = 0.4F;
  Known phong{"highlights", {}, {"", kLobe_phong, {.base_color = {0.7F, 0.3F, 0.1F}}}};
  phong.material.base_color = {0.7F, 0.3F, 0.1F};
  phong.material.lobe = Lobe::phong;
  phong.material.phong_shininess = 200;
  phong.material.phong_specular = {0.2F, 0.3F, 0.1F};
  phong.material.metallic = 0;
  phong.specimen.material.shininess = 200;
  phong.specimen.material.highlight = {0.2F, 0.3F, 0.1F};
  return {lambert, copper, plastic, phong};
}

// Interpolation between samples at unit distance is off by at most an eighth of the second
// derivative, for each of the three coordinates [the remainder of linear interpolation]; the second
// differences of the entries around give that derivative, with a factor of 2 for its change between
// neighbours. Entries are rounded evaluations at rounded directions: 1e-4 of them for a lobe of
// 0.12 rad at directions known to 1e-7 rad, where cells are known to 1e-3 of a cell.
TEST(MeasuredLobe, tables_measured_from_known_materials_are_those_materials_within_the_tables_resolution) {
  for (const Known& known : known_materials()) {
    SCOPED_TRACE(known.name);
    const std::vector<float> rgb = measured(known.material);
    const MeasuredTable table = make_measured_table(rgb);
    std::mt19937 random(8);
    Queries q;
    for (int i = 0; i < 200000; ++i)
      q.add(0, from_cosine(0.05 + 0.95 * uniform(random), uniform(random)),
            from_cosine(0.05 + 0.95 * uniform(random), uniform(random)), 0, 0, 0);
    const Answers by_table = scatter(table, q), exact = test::scatter({known.specimen}, q);
    const auto entry = [&](int h, int d, int p, int c) {
      return double(rgb[std::size_t(3 * ((h * kD + d) * kP + (p + kP) % kP) + c)]);
    };
    std::size_t compared = 0, beyond = 0;
    double worst = 0, worst_share = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const Angles at = angles_of(direction(q, i, 1), direction(q, i, 4));
      const int h0 = int(at.h - 0.5), d0 = int(at.d - 0.5), p0 = int(at.p - 0.5 + kP) - kP;
      if (at.h < 2 || at.d < 2 || h0 + 2 >= kH || d0 + 2 >= kD) continue;
      bool inside = true;
      double second[3][3] = {};
      for (int corner = 0; corner < 8; ++corner) {
        const int h = h0 + (corner & 1), d = d0 + (corner >> 1 & 1), p = p0 + (corner >> 2);
        for (const auto& [dh, dd, dp, axis] : {std::array{1, 0, 0, 0}, {0, 1, 0, 1}, {0, 0, 1, 2}})
          for (int c = 0; c < 3; ++c) {
            const double before = entry(h - dh, d - dd, p - dp, c), middle = entry(h, d, p, c),
                         after = entry(h + dh, d + dd, p + dp, c);
            inside = inside && std::min({before, middle, after}) >= 0;
            second[c][axis] = std::max(second[c][axis], std::abs(before - 2 * middle + after));
          }
      }
      if (!inside) continue;
      ++compared;
      const double cosine = as_float(q.in[6][i]);
      for (std::size_t c = 0; c < 3; ++c) {
        const double f = exact.eval(i, c) / cosine, difference = std::abs(by_table.eval(i, c) / cosine - f);
        const double bound = (second[c][0] + second[c][1] + second[c][2]) / 4 + 1e-4 * f;
        worst = std::max(worst, difference / f);
        worst_share = std::max(worst_share, difference / bound);
        beyond += difference > bound ? 1 : 0;
      }
    }
    std::printf("%s: %zu pairs, off by %.2g of the value at most, %.2f of the bound\n", known.name, compared, worst,
                worst_share);
    EXPECT_GT(compared, 100000U);
    EXPECT_EQ(beyond, 0U);
  }
}

// Of all light that a view receives, by samples of the material itself. Views are two cells of
// theta_d above the horizon at least: nearer ones lie between entries of which some are below it.
TEST(MeasuredLobe, measured_tables_misplace_less_than_a_hundredth_of_the_light) {
  for (const Known& known : known_materials()) {
    const MeasuredTable table = make_measured_table(measured(known.material));
    double most = 0;
    for (const double z : {0.05, 0.1, 0.2, 0.4, 0.7, 0.95, 1.0}) {
      std::mt19937 random(9);
      Queries q;
      for (int i = 0; i < 20000; ++i) q.add(0, from_cosine(z, uniform(random)), random);
      const Answers samples = test::scatter({known.specimen}, q);
      Queries sampled = q;
      for (std::size_t i = 0; i < q.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) sampled.in[4 + k][i] = as_word(float(samples.sample(i).wi[k]));
      const Answers exact = test::scatter({known.specimen}, sampled), by_table = scatter(table, sampled);
      for (std::size_t c = 0; c < 3; ++c) {
        double off = 0, all = 0;
        for (std::size_t i = 0; i < q.size(); ++i) {
          if (samples.sample(i).pdf == 0) continue;
          off += std::abs(by_table.eval(i, c) - exact.eval(i, c)) / samples.sample(i).pdf;
          all += exact.eval(i, c) / samples.sample(i).pdf;
        }
        most = std::max(most, off / all);
        EXPECT_LT(off, 0.01 * all) << known.name << ", cosine " << z;
      }
    }
    std::printf("%s: misplaced at most %.2g\n", known.name, most);
  }
}

}  // namespace
}  // namespace eikon::test
