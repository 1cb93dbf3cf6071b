// SPDX-License-Identifier: Apache-2.0
// The first root of a formula on a ray, against closed forms and polynomials in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "formula/evaluate.h"
#include "formula/kernel_code.h"
#include "formula/parse.h"
#include "kernels/probe.h"
#include "support/random.h"

namespace eikon::test {
namespace {

using formula::Formula;
using glm::dvec3;

struct Ray {
  glm::vec3 o, d;
};
struct Found {
  bool hit = false;
  double t = 0;
  dvec3 p{0.0}, n{0.0};
  double error = 0;
  bool given_up = false;
};

Probe probe(const std::vector<std::string>& texts, unsigned index = 0) {
  std::vector<Formula> formulas;
  for (const std::string& text : texts) formulas.push_back(formula::parse_formula(text));
  Probe probe("implicit");
  probe.append(formula::kernel_code(formulas))
      .define("EK_FORMULA_COUNT", std::to_string(texts.size()))
      .value("formula", index);
  return probe;
}

/// The formulas of this file whose surfaces are traced, all in one program.
const std::vector<std::string> kTraced = {"x^2+y^2+z^2-1",
                                          "(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)",
                                          "(x^2+2.25*y^2+z^2-1)^3-x^2*z^3-0.1125*y^2*z^3",
                                          "1.099511627776e12*(x+2*y-z-0.25)",
                                          "(x^2+y^2+z^2-1)/1.099511627776e12",
                                          "(x^2+y^2+z^2-1)^3",
                                          "(x^2+y^2+z^2-1)^2-1e-6",
                                          "(x^2+y^2+z^2-1)^2",
                                          "abs(x^2+y^2+z^2-1)",
                                          "sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)",
                                          "1/x",
                                          "1/x+0*y",
                                          "tan(x*1.5)-1e9",
                                          "log(x)-1e3",
                                          "sqrt(x)+1",
                                          "x^2+y^2+z^2+1e-6",
                                          "1e6*(x+2*y-z-0.25)",
                                          "exp(-x^2-y^2)+exp(-(x-1)^2-z^2)-0.8",
                                          "x*y - x*y + 1e-5"};

/// text: one of kTraced
std::vector<Found> trace(const std::string& text, const std::vector<Ray>& rays, glm::vec3 lo, glm::vec3 hi) {
  std::vector<Words> in(12);
  for (const Ray& ray : rays)
    for (int axis = 0; axis < 3; ++axis) {
      in[std::size_t(axis)].push_back(as_word(ray.o[axis]));
      in[std::size_t(3 + axis)].push_back(as_word(ray.d[axis]));
      in[std::size_t(6 + axis)].push_back(as_word(lo[axis]));
      in[std::size_t(9 + axis)].push_back(as_word(hi[axis]));
    }
  std::vector<Found> found(rays.size());
  const auto place = std::ranges::find(kTraced, text);
  EXPECT_NE(place, kTraced.end()) << text;
  if (place == kTraced.end()) return found;
  const auto out = probe(kTraced, unsigned(place - kTraced.begin())).run("probe_implicit_hits", in, 10);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto value = [&](std::size_t k) { return double(as_float(out[k][i])); };
    found[i] = {.hit = out[0][i] != 0,
                .t = value(1),
                .p = {value(2), value(3), value(4)},
                .n = {value(5), value(6), value(7)},
                .error = value(8),
                .given_up = out[9][i] != 0};
  }
  return found;
}

/// A point of the cube of so much to each side of the origin.
dvec3 random_point(Random& random, double half) {
  return {uniform(random, -half, half), uniform(random, -half, half), uniform(random, -half, half)};
}

// From anywhere within `distance` towards anywhere within `aim`.
std::vector<Ray> rays_at(std::size_t count, double distance, double aim) {
  Random random(3);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const dvec3 o = random_point(random, distance), d = random_point(random, aim) - o;
    if (glm::length(d) > 1e-3) rays.push_back({glm::vec3(o), glm::vec3(d * uniform(random, 0.01, 3))});
  }
  return rays;
}

using Polynomial = std::vector<double>;  // by rising powers

double at(const Polynomial& p, double t) {
  double value = 0;
  for (std::size_t i = p.size(); i-- > 0;) value = value * t + p[i];
  return value;
}
Polynomial operator+(Polynomial a, const Polynomial& b) {
  a.resize(std::max(a.size(), b.size()));
  for (std::size_t i = 0; i < b.size(); ++i) a[i] += b[i];
  return a;
}
Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial product(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) product[i + j] += a[i] * b[j];
  return product;
}
// All places in (lo, hi) where p changes its sign, between those where its derivative does.
std::vector<double> roots(const Polynomial& p, double lo, double hi) {
  if (p.size() < 2) return {};
  Polynomial slope;
  for (std::size_t i = 1; i < p.size(); ++i) slope.push_back(double(i) * p[i]);
  std::vector<double> ends = roots(slope, lo, hi), found;
  ends.insert(ends.begin(), lo);
  ends.push_back(hi);
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    double a = ends[i], b = ends[i + 1];
    if ((at(p, a) < 0) == (at(p, b) < 0)) continue;
    for (int k = 0; k < 200; ++k) {
      const double m = 0.5 * (a + b);
      ((at(p, m) < 0) == (at(p, a) < 0) ? a : b) = m;
    }
    found.push_back(0.5 * (a + b));
  }
  return found;
}

// f(o + t d) of rays, for formulas that are polynomials: `of` is given x, y, z as such.
template <class Of>
void expect_polynomial(const std::string& text, const std::vector<Ray>& rays, float half, double noise, const Of& of) {
  const std::vector<Found> found = trace(text, rays, glm::vec3(-half), glm::vec3(half));
  std::size_t hits = 0, doubtful = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const dvec3 o(rays[i].o), d(rays[i].d);
    const double length = glm::length(d);
    double begin = 0, end = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (-double(half) - o[axis]) / d[axis], b = (double(half) - o[axis]) / d[axis];
      begin = std::max(begin, std::min(a, b));
      end = std::min(end, std::max(a, b));
    }
    ASSERT_FALSE(found[i].given_up) << text << " ray " << i;
    const Polynomial p = of(Polynomial{o.x, d.x}, Polynomial{o.y, d.y}, Polynomial{o.z, d.z});
    const std::vector<double> exact = begin < end ? roots(p, begin, end) : std::vector<double>{};
    const bool same =
        found[i].hit == !exact.empty() && (exact.empty() || std::abs(found[i].t - exact[0]) * length < 1e-4);
    hits += found[i].hit ? 1U : 0U;
    if (same) continue;
    // Else f all but touches 0 at the earlier of the two.
    ++doubtful;
    double t = found[i].hit ? found[i].t : exact[0];
    if (found[i].hit && !exact.empty()) t = std::min(found[i].t, exact[0]);
    ASSERT_LT(std::abs(at(p, t)), noise) << text << " ray " << i << ": found " << found[i].hit << " " << found[i].t
                                         << ", exact " << (exact.empty() ? -1.0 : exact[0]);
  }
  EXPECT_GT(hits, rays.size() / 4) << text;
  EXPECT_LT(doubtful, rays.size() / 500 + 1) << text;
}

TEST(Implicit, generated_code_has_the_bits_of_the_host_in_numbers_and_intervals) {
  const std::vector<std::string> texts = {"x^2+y^2+z^2-1",
                                          "sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)",
                                          "(x^2+9/4*y^2+z^2-1)^3-x^2*z^3-9/80*y^2*z^3",
                                          "exp(-x^2)*log(y+4)-sqrt(abs(z))+max(x,min(y,z))-atan(x*y)/z",
                                          "tan(x)+sinh(y)/cosh(z)-tanh(x-y)+x^-3+z^7-1.7*y^64",
                                          "(x+3)^y-(y-z)*-x"};
  Random random(3);
  std::vector<Words> in(12);
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::exp2(uniform(random, -20, 8)), width = std::exp2(uniform(random, -24, 2));
    for (std::size_t k = 0; k < 6; ++k) in[k].push_back(as_word(float(uniform(random, -scale, scale))));
    for (std::size_t k = 0; k < 3; ++k) {
      in[6 + k].push_back(in[k].back());
      in[9 + k].push_back(as_word(as_float(in[k].back()) + float(width * scale * uniform(random, 0, 1))));
    }
  }
  for (unsigned index = 0; index < texts.size(); ++index) {
    const Formula f = formula::parse_formula(texts[index]);
    const auto out = probe(texts, index).run("probe_implicit_values", in, 9);
    for (std::size_t i = 0; i < in[0].size(); ++i) {
      formula::Point point{};
      formula::Region region{};
      for (std::size_t k = 0; k < 6; ++k) {
        point[k] = as_float(in[k][i]);
        region[k] = k < 3 ? formula::Bounds1{as_float(in[6 + k][i]), as_float(in[9 + k][i])}
                          : formula::Bounds1{point[k], point[k]};
      }
      const auto same = [&](std::size_t k, float expected) {
        return out[k][i] == as_word(expected) || (std::isnan(expected) && std::isnan(as_float(out[k][i])));
      };
      ASSERT_TRUE(same(0, evaluate(f.expressions, f.value, point))) << texts[index] << " item " << i;
      for (std::size_t axis = 0; axis < 3; ++axis)
        ASSERT_TRUE(same(1 + axis, evaluate(f.expressions, f.gradient[axis], point)))
            << texts[index] << " axis " << axis;
      const formula::RegionValue value = evaluate(f.expressions, f.value, region),
                                 slope = evaluate(f.expressions, f.slope, region);
      ASSERT_TRUE(same(4, value.bounds.lo) && same(5, value.bounds.hi)) << texts[index] << " item " << i;
      ASSERT_TRUE(same(6, slope.bounds.lo) && same(7, slope.bounds.hi)) << texts[index] << " item " << i;
      ASSERT_EQ(out[8][i] != 0, value.undefined || slope.undefined) << texts[index] << " item " << i;
    }
  }
}

TEST(Implicit, polynomial_surfaces_are_met_where_their_first_root_is) {
  const std::vector<Ray> rays = rays_at(20000, 4, 1.2);
  expect_polynomial("x^2+y^2+z^2-1", rays, 1.5F, 4e-6,
                    [](auto x, auto y, auto z) { return x * x + y * y + z * z + Polynomial{-1}; });
  expect_polynomial("(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)", rays, 2, 1e-4, [](auto x, auto y, auto z) {
    const Polynomial s = x * x + y * y + z * z + Polynomial{0.75};
    return s * s + Polynomial{-4} * (x * x + y * y);
  });
  expect_polynomial("(x^2+2.25*y^2+z^2-1)^3-x^2*z^3-0.1125*y^2*z^3", rays, 1.5F, 1e-4, [](auto x, auto y, auto z) {
    const Polynomial s = x * x + Polynomial{2.25} * y * y + z * z + Polynomial{-1};
    return s * s * s + Polynomial{-1} * x * x * z * z * z + Polynomial{-double(0.1125F)} * y * y * z * z * z;
  });
  // The same plane and sphere, 2^40 times as steep, 2^-40 times, and flattened by a cube.
  expect_polynomial("1.099511627776e12*(x+2*y-z-0.25)", rays, 1, 1e8, [](auto x, auto y, auto z) {
    return Polynomial{0x1p40} * (x + Polynomial{2} * y + Polynomial{-1} * z + Polynomial{-0.25});
  });
  expect_polynomial("(x^2+y^2+z^2-1)/1.099511627776e12", rays, 1.5F, 1e-17, [](auto x, auto y, auto z) {
    return Polynomial{0x1p-40} * (x * x + y * y + z * z + Polynomial{-1});
  });
  expect_polynomial("(x^2+y^2+z^2-1)^3", rays, 1.5F, 4e-6, [](auto x, auto y, auto z) {
    return x * x + y * y + z * z +
           Polynomial{-1};  // the same roots, which a triple root's own coefficients do not tell
  });
  // Two skins a thousandth apart, of which the outer one is met.
  expect_polynomial("(x^2+y^2+z^2-1)^2-1e-6", rays, 1.5F, 4e-8, [](auto x, auto y, auto z) {
    const Polynomial s = x * x + y * y + z * z + Polynomial{-1};
    return s * s + Polynomial{-double(1e-6F)};
  });
}

TEST(Implicit, G21_a_sphere_is_as_the_analytic_one_from_outside_inside_and_along_its_rim) {
  Random random(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 30000; ++i) {
    const dvec3 o =
        i % 3 == 0 ? random_point(random, 0.55) : random_direction(random) * std::exp2(uniform(random, 0.1, 12));
    // Every third is aimed at the rim, within a thousandth.
    const dvec3 side = glm::normalize(glm::cross(o, random_direction(random)));
    const double offset = i % 3 == 1 ? 1 - std::exp2(uniform(random, -24, -10)) : uniform(random, 0, 1.1);
    rays.push_back({glm::vec3(o), glm::vec3(side * offset - o)});
  }
  const std::vector<Found> found = trace("x^2+y^2+z^2-1", rays, glm::vec3(-1), glm::vec3(1));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const dvec3 o(rays[i].o), d(rays[i].d);
    const double a = glm::dot(d, d), b = glm::dot(o, d), c = glm::dot(o, o) - 1, square = b * b - a * c;
    const double distance = glm::length(glm::cross(o, d)) / std::sqrt(a);
    if (std::abs(distance - 1) < 1e-6 * (1 + glm::length(o))) continue;  // a ray in floats may miss it or not
    ASSERT_EQ(found[i].hit, square > 0) << i << " passes at " << distance;
    if (!found[i].hit) continue;
    const double near = (-b - std::sqrt(square)) / a, t = near > 0 ? near : (-b + std::sqrt(square)) / a;
    // Near the rim depth is as uncertain as the root of what the ray's place is.
    const double depth_error = std::abs(found[i].t - t) * std::sqrt(a),
                 grazing = std::sqrt(std::abs(1 - distance * distance));
    ASSERT_LE(depth_error, 1e-6 * (1 + glm::length(o)) / grazing + 1e-6 * t * std::sqrt(a)) << i;
    ASSERT_LE(std::abs(glm::length(found[i].p) - 1), 1e-6) << i;
    ASSERT_LE(glm::length(found[i].n - glm::normalize(found[i].p)), 1e-6) << i;
    ASSERT_LE(found[i].error, 8e-6) << i;
  }
}

// A surface that f touches without crossing it, which no change of sign tells of.
TEST(Implicit, double_roots_are_found) {
  const std::vector<Ray> rays = rays_at(5000, 3, 0.9);
  const std::vector<Found> once = trace("x^2+y^2+z^2-1", rays, glm::vec3(-1.5F), glm::vec3(1.5F));
  const std::vector<Found> twice = trace("(x^2+y^2+z^2-1)^2", rays, glm::vec3(-1.5F), glm::vec3(1.5F));
  const std::vector<Found> kinked = trace("abs(x^2+y^2+z^2-1)", rays, glm::vec3(-1.5F), glm::vec3(1.5F));
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const dvec3 o(rays[i].o), d(rays[i].d);
    const double distance = glm::length(glm::cross(o, d)) / glm::length(d);
    if (std::abs(distance - 1) < 1e-5) continue;
    ASSERT_EQ(twice[i].hit, once[i].hit) << i;
    ASSERT_EQ(kinked[i].hit, once[i].hit) << i;
    if (!once[i].hit) continue;
    ++hits;
    const double bound = 1e-5 / std::sqrt(std::abs(1 - distance));
    ASSERT_NEAR(twice[i].t * glm::length(d), once[i].t * glm::length(d), bound) << i;
    ASSERT_NEAR(kinked[i].t * glm::length(d), once[i].t * glm::length(d), bound) << i;
  }
  EXPECT_GT(hits, 2000U);
}

// f < 0 behind the first root that double precision finds in steps of a ten-thousandth.
TEST(Implicit, a_gyroid_is_met_first_from_outside_and_from_inside_its_passages) {
  const std::string text = "sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)";
  const std::vector<Ray> rays = rays_at(3000, 6, 6);
  const std::vector<Found> found = trace(text, rays, glm::vec3(-6.5F), glm::vec3(6.5F));
  const Formula f = formula::parse_formula(text);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_FALSE(found[i].given_up) << i;
    const dvec3 o(rays[i].o), d = glm::normalize(dvec3(rays[i].d));
    const auto value = [&](double t) {
      const dvec3 p = o + t * d;
      return evaluate_double(f.expressions, f.value, {p.x, p.y, p.z, 0, 0, 0});
    };
    const double t = found[i].t * glm::length(dvec3(rays[i].d));
    if (!found[i].hit) continue;
    ++hits;
    ASSERT_LT(std::abs(value(t)), 2e-5) << i;
    const bool negative = value(0) < 0;
    for (double s = 0; s < t - 1e-2; s += 1e-2)
      ASSERT_TRUE((value(s) < 0) == negative || std::abs(value(s)) < 1e-5) << i << " at " << s;
  }
  EXPECT_GT(hits, 2900U);
}

TEST(Implicit, poles_edges_of_domains_and_rays_that_are_none_give_no_hit) {
  const std::vector<Ray> rays = {{{-2, 0.1F, 0.2F}, {1, 0, 0}}, {{-2, 0.3F, 0.7F}, {3, 0.01F, 0}},
                                 {{0, 0, 5}, {0, 0, -1}},       {{0.25F, -4, 0}, {0, 1, 0.01F}},
                                 {{-2, 5, 0}, {1, 0, 0}},       {{-2, 0, 0}, {-1, 0, 0}}};
  for (const char* text : {"1/x", "1/x+0*y", "tan(x*1.5)-1e9", "log(x)-1e3", "sqrt(x)+1", "x^2+y^2+z^2+1e-6"})
    for (const Found& found : trace(text, rays, glm::vec3(-1), glm::vec3(1))) EXPECT_FALSE(found.hit) << text;
  const float nan = NAN, infinity = INFINITY;
  const std::vector<Ray> broken = {{{nan, 0, 0}, {1, 0, 0}},
                                   {{-2, 0, 0}, {nan, 0, 0}},
                                   {{-2, 0, 0}, {0, 0, 0}},
                                   {{infinity, 0, 0}, {-1, 0, 0}},
                                   {{-2, 0, 0}, {infinity, 0, 0}}};
  for (const Found& found : trace("x^2+y^2+z^2-1", broken, glm::vec3(-1), glm::vec3(1))) EXPECT_FALSE(found.hit);
}

TEST(Implicit, a_ray_that_leaves_by_the_error_does_not_meet_its_own_surface) {
  const struct {
    const char* text;
    float half;
  } cases[] = {{"x^2+y^2+z^2-1", 1.5F},
               {"(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)", 2},
               {"(x^2+y^2+z^2-1)^2-1e-6", 1.5F},
               {"1e6*(x+2*y-z-0.25)", 1},
               {"exp(-x^2-y^2)+exp(-(x-1)^2-z^2)-0.8", 2}};
  for (const auto& [text, half] : cases) {
    const std::vector<Ray> rays = rays_at(4000, 3, 0.9);
    const std::vector<Found> found = trace(text, rays, glm::vec3(-half), glm::vec3(half));
    const Formula f = formula::parse_formula(text);
    Random random(3);
    std::vector<Ray> leaving;
    std::vector<bool> front;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!found[i].hit) continue;
      const dvec3 n = found[i].n * (i % 2 == 0 ? 1.0 : -1.0);
      dvec3 d = random_direction(random);
      d = glm::dot(d, n) < 0 ? -d : d;
      if (i % 4 < 2) d = glm::normalize(d - n * glm::dot(d, n) * (1 - std::exp2(uniform(random, -20, 0))));  // grazing
      front.push_back(i % 2 == 0);
      leaving.push_back({glm::vec3(found[i].p + n * found[i].error), glm::vec3(d)});
      EXPECT_LT(found[i].error, 1e-4) << text;
    }
    const std::vector<Found> again = trace(text, leaving, glm::vec3(-half), glm::vec3(half));
    for (std::size_t i = 0; i < leaving.size(); ++i) {
      if (!again[i].hit) continue;
      // What it meets is there in double, too: f crosses 0, or comes close to it, behind a
      // start on the right side: a ray that grazes the hollow side may.
      const dvec3 o(leaving[i].o), d(leaving[i].d);
      const auto value = [&](double t) {
        const dvec3 p = o + d * t;
        return evaluate_double(f.expressions, f.value, {p.x, p.y, p.z, 0, 0, 0});
      };
      const double beyond = again[i].t * 1.01 + 1e-6;
      ASSERT_EQ(value(0) > 0, front[i]) << text << " ray " << i;
      ASSERT_TRUE((value(beyond) > 0) != front[i] || std::abs(value(again[i].t)) < 0.5 * std::abs(value(0)))
          << text << " ray " << i << " meets it again at " << again[i].t << ", where f goes from " << value(0) << " to "
          << value(again[i].t) << " and " << value(beyond);
    }
  }
}

// Intervals do not see that the products cancel: f is known to be above 0 in small pieces alone.
TEST(Implicit, what_takes_too_many_steps_is_given_up_and_says_so) {
  const std::vector<Ray> rays = {{{-2, 0.1F, 0.2F}, {1, 0.03F, 0.01F}}, {{-2, 0.1F, 0.2F}, {-1, 0, 0}}};
  const std::vector<Found> found = trace("x*y - x*y + 1e-5", rays, glm::vec3(-1), glm::vec3(1));
  EXPECT_TRUE(found[0].given_up);
  EXPECT_FALSE(found[0].hit);
  EXPECT_FALSE(found[1].given_up);
}

}  // namespace
}  // namespace eikon::test
