// SPDX-License-Identifier: Apache-2.0
// Blinn's highlights and translucent sheets against closed forms.
#include <gtest/gtest.h>

#include "kernels/bsdf/bsdf_probe.h"
#include "kernels/statistics.h"

namespace eikon::test {
namespace {

Mean albedo_of(const Specimen& specimen, double angle, unsigned samples = 200000) {
  std::mt19937 random(7);
  Queries q;
  q.draw(samples, 0, from_angle(angle, 0.3), random);
  const Answers answers = scatter({specimen}, q);
  std::vector<double> weights;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Sampled s = answers.sample(i);
    weights.push_back(s.pdf > 0 ? s.weight[0] : 0);
  }
  return mean_of(weights);
}

Specimen highlight(float shininess, float specular, float base) {
  ProbeMaterial material{.base_color = {base, base, base}};
  material.shininess = shininess;
  material.highlight = {specular, specular, specular};
  return {"highlight", kLobe_phong, material};
}

TEST(Phong, a_white_highlight_reflects_everything_at_normal_incidence_and_nowhere_more) {
  for (const float n : {0.0F, 1.0F, 7.5F, 60.0F, 1000.0F, 10000.0F}) {
    const Mean normal = albedo_of(highlight(n, 1, 1), 0);
    EXPECT_NEAR(normal.mean, 1, 4 * normal.standard_error + 1e-3) << n;
    for (const double angle : {20.0, 45.0, 70.0, 85.0, 89.0}) {
      const Mean m = albedo_of(highlight(n, 1, 1), angle, 50000);
      EXPECT_LE(m.mean, 1 + 4 * m.standard_error + 1e-3) << n << ", " << angle << " degrees";
    }
  }
}

TEST(Phong, M5_highlight_and_base_share_the_light) {
  for (const float n : {2.0F, 50.0F, 2000.0F}) {
    const Mean both = albedo_of(highlight(n, 0.3F, 1), 0), base = albedo_of(highlight(n, 0, 0.5F), 60);
    EXPECT_NEAR(both.mean, 1, 4 * both.standard_error + 1e-3);
    EXPECT_NEAR(base.mean, 0.5, 1e-5) << "without a highlight it is Lambert's";
  }
}

TEST(Phong, the_highlight_is_the_normalised_power_of_the_cosine) {
  for (const float n : {3.0F, 40.0F, 500.0F}) {
    std::mt19937 random(8);
    Queries q;
    for (int i = 0; i < 20000; ++i)
      q.add(0, from_cosine(0.05 + 0.95 * uniform(random), uniform(random)),
            from_cosine(0.05 + 0.95 * uniform(random), uniform(random)), 0, 0, 0);
    const Answers answers = scatter({highlight(n, 0.8F, 0.5F)}, q);
    for (std::size_t i = 0; i < q.size(); ++i) {
      double sum[3], length2 = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        sum[k] = double(as_float(q.in[1 + k][i])) + as_float(q.in[4 + k][i]);
        length2 += sum[k] * sum[k];
      }
      const double pi = std::numbers::pi, scale = (n + 2.0) * (n + 4.0) / (8 * pi * (std::exp2(-n / 2) + n));
      const double f = (0.5 * 0.2 / pi + 0.8 * scale * std::pow(sum[2] / std::sqrt(length2), n)) * as_float(q.in[6][i]);
      ASSERT_NEAR(answers.eval(i, 0), f, (1e-6 + 2e-7 * n) * f + 1e-12);
    }
  }
}

TEST(Translucence, M5_a_white_sheet_returns_all_light_to_either_side) {
  for (const float roughness : {0.0F, 0.1F, 0.4F, 1.0F})
    for (const float share : {0.0F, 0.3F, 1.0F})
      for (const double angle : {0.0, 45.0, 80.0, 89.0}) {
        ProbeMaterial material{.roughness = roughness};
        material.diffuse_transmission = share;
        const Mean m = albedo_of({"paper", kLobe_transmission, material}, angle);
        SCOPED_TRACE(std::to_string(roughness) + ", " + std::to_string(share) + ", " + std::to_string(angle));
        EXPECT_LE(m.mean, 1 + 4 * m.standard_error + 1e-6);
        EXPECT_GE(m.mean, (roughness == 0 ? 1 - 2e-6 : 0.993) - 4 * m.standard_error);
      }
}

TEST(Translucence, what_passes_is_the_colour_times_the_share_of_lambert) {
  ProbeMaterial material{.base_color = {0.5F, 0.5F, 0.5F}};
  material.specular = 0;
  material.diffuse_transmission = 0.25F;
  material.diffuse_transmission_color = {0.2F, 0.4F, 0.8F};
  std::mt19937 random(9);
  Queries q;
  for (int i = 0; i < 2000; ++i)
    q.add(0, from_cosine(0.05 + 0.95 * uniform(random), uniform(random)),
          from_cosine((i % 2 == 0 ? 1 : -1) * (0.05 + 0.95 * uniform(random)), uniform(random)), 0, 0, 0);
  const Answers answers = scatter({{"sheet", kLobe_transmission, material}}, q);
  for (std::size_t i = 0; i < q.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double z = as_float(q.in[6][i]);
      const double albedo = z > 0 ? 0.75 * 0.5 : 0.25 * double(material.diffuse_transmission_color[c]);
      ASSERT_NEAR(answers.eval(i, c), albedo * std::abs(z) / std::numbers::pi, 1e-6);
    }
}

}  // namespace
}  // namespace eikon::test
