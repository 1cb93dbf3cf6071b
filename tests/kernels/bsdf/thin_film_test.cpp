// SPDX-License-Identifier: Apache-2.0
// Reflectance of thin films against interference itself, wave length by wave length.
#include <gtest/gtest.h>

#include <complex>
#include <numbers>

#include "kernels/bsdf/bsdf_probe.h"

namespace eikon::test {
namespace {

struct Film {
  double index, nm, base;  // base: index of what is below
};

std::vector<std::array<double, 3>> film(const std::vector<std::pair<Film, double>>& queries) {
  std::vector<Words> in(4);
  for (const auto& [film, cosine] : queries) {
    const double r = (film.base - 1) / (film.base + 1);
    in[0].push_back(as_word(float(film.index)));
    in[1].push_back(as_word(float(film.nm * 1e-9)));
    in[2].push_back(as_word(float(r * r)));
    in[3].push_back(as_word(float(cosine)));
  }
  const auto out = thin_film_probe().run("probe_thin_film_reflectance", in, 3);
  std::vector<std::array<double, 3>> all;
  for (std::size_t i = 0; i < queries.size(); ++i)
    all.push_back({as_float(out[0][i]), as_float(out[1][i]), as_float(out[2][i])});
  return all;
}

using Complex = std::complex<double>;

/// [Airy 1833]: all orders, at one wave length, unpolarised, of a film between air and a base,
/// which may absorb: index n + i k.
double airy(double index, double nm, Complex base, double cosine, double lambda_nm) {
  const double sine2 = 1 - cosine * cosine;
  const Complex cos_film = std::sqrt(1 - sine2 / (index * index)), cos_base = std::sqrt(1.0 - sine2 / (base * base));
  const auto across = [](Complex n1, Complex c1, Complex n2, Complex c2) {
    return (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2);
  };
  const double phase = 2 * std::numbers::pi * 2 * index * nm * cos_film.real() / lambda_nm;
  const Complex turn = std::polar(1.0, phase);
  double sum = 0;
  // Across the plane of incidence, and along it, where cosines change places (and both signs turn).
  for (const bool along : {false, true}) {
    const auto r = [&](Complex n1, Complex c1, Complex n2, Complex c2) {
      return along ? across(n1, c2, n2, c1) : across(n1, c1, n2, c2);
    };
    const Complex top = r(1, cosine, index, cos_film), bottom = r(index, cos_film, base, cos_base);
    sum += 0.5 * std::norm((top + bottom * turn) / (1.0 + top * bottom * turn));
  }
  return sum;
}

/// Sensitivities of the eye, in Gaussians as of the kernel (their fit to those of the CIE is not
/// what is tested): linear sRGB over that of an even spectrum.
std::array<double, 3> colour(double index, double nm, Complex base, double cosine) {
  struct Gauss {
    int channel;
    double weight, middle, variance;
  };
  constexpr Gauss kGauss[] = {{0, 5.4856e-13, 1.6810e6, 4.3278e9},
                              {0, 9.7470e-14, 2.2399e6, 4.5282e9},
                              {1, 4.4201e-13, 1.7953e6, 9.3046e9},
                              {2, 5.2481e-13, 2.2084e6, 6.6121e9}};
  double xyz[3] = {0, 0, 0}, white[3] = {0, 0, 0};
  for (const Gauss& g : kGauss) {
    // Its Fourier transform is weight sqrt(2 pi variance) cos(middle phase) exp(-variance phase^2):
    // over the wave number, in turns.
    const double scale = g.weight * std::sqrt(2 * std::numbers::pi * g.variance), width = std::sqrt(2 * g.variance);
    double sum = 0, all = 0;
    for (int i = -400; i <= 400; ++i) {
      const double x = 0.0125 * i, number = g.middle + width * x, weight = std::exp(-x * x / 2);
      sum += weight * airy(index, nm, base, cosine, 1e9 / number);
      all += weight;
    }
    xyz[g.channel] += scale * sum / all;
    white[g.channel] += scale;
  }
  constexpr double kRgb[3][3] = {
      {3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};
  std::array<double, 3> rgb{};
  for (int c = 0; c < 3; ++c) {
    double of_film = 0, of_white = 0;
    for (int k = 0; k < 3; ++k) of_film += kRgb[c][k] * xyz[k], of_white += kRgb[c][k] * white[k];
    rgb[std::size_t(c)] = of_film / of_white;
  }
  return rgb;
}

TEST(ThinFilm, reflects_at_normal_incidence_what_interference_does_at_every_wave_length) {
  std::vector<std::pair<Film, double>> queries;
  for (const double index : {1.3, 1.6, 2.0})
    for (const double base : {1.2, 1.5, 2.5})
      for (double nm = 0; nm < 1200; nm += 40) queries.push_back({{index, nm, base}, 1});
  const auto found = film(queries);
  double worst = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Film& at = queries[i].first;
    const auto expected = colour(at.index, at.nm, at.base, 1);
    for (std::size_t c = 0; c < 3; ++c) {
      // The third order is left out: below both amplitudes to the third, twice, in colours that
      // amplify by at most 4.4; and what is out of gamut, or above the bound of any wave length, is
      // cut.
      const double top = (queries[i].first.index - 1) / (queries[i].first.index + 1),
                   bottom = (queries[i].first.base - queries[i].first.index) /
                            (queries[i].first.base + queries[i].first.index);
      const double left_out = 2 * 4.4 * std::pow(std::abs(top * bottom), 3) / (1 - std::abs(top * bottom));
      const double most = std::pow((std::abs(top) + std::abs(bottom)) / (1 + std::abs(top * bottom)), 2);
      const double cut = std::clamp(expected[c], 0.0, most);
      EXPECT_NEAR(found[i][c], cut, left_out + 2e-4)
          << "index " << queries[i].first.index << ", " << queries[i].first.nm << " nm on " << queries[i].first.base
          << ", channel " << c;
      worst = std::max(worst, std::abs(found[i][c] - cut));
    }
  }
  std::printf("thin films: within %.2g of interference at normal incidence\n", worst);
}

TEST(ThinFilm, without_thickness_or_of_the_index_of_air_is_not_there) {
  std::vector<std::pair<Film, double>> queries;
  for (const double cosine : {1.0, 0.6, 0.2, 0.01}) {
    queries.push_back({{1.5, 0, 1.6}, cosine});
    queries.push_back({{1, 400, 1.6}, cosine});
  }
  const auto found = film(queries);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const double f0 = std::pow(0.6 / 2.6, 2), schlick = f0 + (1 - f0) * std::pow(1 - queries[i].second, 5);
    for (const double channel : found[i]) EXPECT_NEAR(channel, schlick, 2e-3 * schlick) << i;
  }
}

TEST(ThinFilm, never_reflects_more_than_all_or_less_than_nothing) {
  std::mt19937 random(3);
  std::vector<std::pair<Film, double>> queries;
  for (int i = 0; i < 50000; ++i) {
    const double grazing = std::pow(uniform(random), 4);
    queries.push_back(
        {{1 + 2 * uniform(random), 3000 * std::pow(uniform(random), 2), 1 + 9 * std::pow(uniform(random), 3)},
         grazing});
  }
  for (const auto& rgb : film(queries))
    for (const double channel : rgb) {
      ASSERT_GE(channel, 0);
      ASSERT_LE(channel, 1);
    }
}

/// A film on metal: index n + i k of R, G and B.
struct MetalFilm {
  double index, nm, cosine;
  std::array<Complex, 3> base;
};

std::vector<std::array<double, 3>> metal_film(const std::vector<MetalFilm>& queries) {
  std::vector<Words> in(9);
  for (const MetalFilm& q : queries) {
    in[0].push_back(as_word(float(q.index)));
    in[1].push_back(as_word(float(q.nm * 1e-9)));
    for (std::size_t c = 0; c < 3; ++c) {
      in[2 + c].push_back(as_word(float(q.base[c].real())));
      in[5 + c].push_back(as_word(float(q.base[c].imag())));
    }
    in[8].push_back(as_word(float(q.cosine)));
  }
  const auto out = thin_film_probe().run("probe_thin_film_conductor", in, 3);
  std::vector<std::array<double, 3>> all;
  for (std::size_t i = 0; i < queries.size(); ++i)
    all.push_back({as_float(out[0][i]), as_float(out[1][i]), as_float(out[2][i])});
  return all;
}

const std::array<Complex, 3> kGold{Complex(0.16779, 3.137816), Complex(0.350409, 2.714063), Complex(1.508458, 1.87885)},
    kAluminium{Complex(1.3, 7.5), Complex(0.96, 6.69), Complex(0.63, 5.5)},
    kOdd{Complex(2.9, 3.1), Complex(1.5, 0), Complex(0.2, 0.4)};  // chromium, glass, what is thinner than air

/// What the orders beyond the eighth can add: 2 A |q|^m each, of either polarisation, in colours
/// that amplify by at most 4.4.
double beyond_eighth_order(double index, Complex base, double cosine) {
  const double sine2 = 1 - cosine * cosine;
  const Complex cos_film = std::sqrt(1 - sine2 / (index * index)), cos_base = std::sqrt(1.0 - sine2 / (base * base));
  double sum = 0;
  for (const bool along : {false, true}) {
    const auto r2 = [&](Complex n1, Complex c1, Complex n2, Complex c2) {
      if (along) std::swap(c1, c2);
      return std::norm((n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2));
    };
    const double top = r2(1, cosine, index, cos_film), bottom = std::min(r2(index, cos_film, base, cos_base), 1.0);
    const double q = std::sqrt(top * bottom), absorbed = (1 - top) * (1 - bottom) / (1 - top * bottom);
    sum += 0.5 * 2 * 4.4 * absorbed * std::pow(q, 9) / (1 - q);
  }
  return sum;
}

TEST(ThinFilm, on_metal_reflects_at_every_angle_what_interference_does_at_every_wave_length) {
  std::vector<MetalFilm> queries;
  for (const auto& base : {kGold, kAluminium, kOdd})
    for (const double index : {1.3, 1.7, 2.4})
      for (const double cosine : {1.0, 0.75, 0.4, 0.1})
        for (const double nm : {5.0, 60.0, 130.0, 250.0, 420.0, 900.0}) queries.push_back({index, nm, cosine, base});
  const auto found = metal_film(queries);
  double worst = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const MetalFilm& q = queries[i];
    for (std::size_t c = 0; c < 3; ++c) {
      const double expected = std::clamp(colour(q.index, q.nm, q.base[c], q.cosine)[c], 0.0, 1.0);
      // Floats: the angle of reflection within a film of q.nm is known to 1e-7 of some turns.
      EXPECT_NEAR(found[i][c], expected, beyond_eighth_order(q.index, q.base[c], q.cosine) + 2e-4)
          << "index " << q.index << ", " << q.nm << " nm on " << q.base[c] << ", cosine " << q.cosine << ", channel "
          << c;
      worst = std::max(worst, std::abs(found[i][c] - expected));
    }
  }
  std::printf("thin films on metal: within %.2g of interference\n", worst);
}

TEST(ThinFilm, on_metal_without_thickness_or_of_the_index_of_air_is_not_there) {
  std::vector<MetalFilm> queries;
  for (const auto& base : {kGold, kAluminium, kOdd})
    for (const double cosine : {1.0, 0.6, 0.2, 0.01, 0.0}) {
      queries.push_back({1.5, 0, cosine, base});
      queries.push_back({1, 400, cosine, base});
    }
  const auto found = metal_film(queries);
  for (std::size_t i = 0; i < queries.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const Complex n2 = queries[i].base[c] * queries[i].base[c];
      const double cosine = queries[i].cosine;
      const Complex g = std::sqrt(n2 - (1 - cosine * cosine));
      const double bare =
          0.5 * (std::norm((cosine - g) / (cosine + g)) + std::norm((n2 * cosine - g) / (n2 * cosine + g)));
      EXPECT_NEAR(found[i][c], bare, 3e-6) << i << ", channel " << c;
    }
}

TEST(ThinFilm, on_metal_reflects_no_more_than_all_and_no_less_than_nothing) {
  std::mt19937 random(4);
  std::vector<MetalFilm> queries;
  for (int i = 0; i < 50000; ++i) {
    const auto index = [&] {
      const double n = std::exp(12 * uniform(random) - 6), k = i % 4 == 0 ? 0 : std::exp(12 * uniform(random) - 6);
      return Complex(n, k);
    };
    queries.push_back({1 + 2 * uniform(random),
                       3000 * std::pow(uniform(random), 2),
                       std::pow(uniform(random), 3),
                       {index(), index(), index()}});
  }
  queries.push_back({1000, 1e5, 0, {Complex(0, 0), Complex(16384, 16384), Complex(0, 16384)}});
  queries.push_back({1000, 1e5, 1, {Complex(0, 0), Complex(16384, 16384), Complex(0, 16384)}});
  for (const auto& rgb : metal_film(queries))
    for (const double channel : rgb) {
      ASSERT_GE(channel, 0);
      ASSERT_LE(channel, 1);
    }
}

TEST(ThinFilm, thick_ones_lose_their_colours) {
  const auto found = film({{{1.4, 40000, 1.5}, 1.0}});
  EXPECT_NEAR(found[0][0], found[0][1], 1e-4);
  EXPECT_NEAR(found[0][1], found[0][2], 1e-4);
}

}  // namespace
}  // namespace eikon::test
