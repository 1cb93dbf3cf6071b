// SPDX-License-Identifier: Apache-2.0
// Estimates the expectation mu of a pixel, and 1 / (mu^2 + eps), by which its squared error is
// divided (film_error.cpp). The functions work on one pixel, or on kPixelLanes of them, with the
// same bits.
#pragma once
#include "film/neighbours.h"
#include "image/relative_error.h"

namespace eikon {

#define EK_INLINE inline __attribute__((always_inline))

// The neighbours lie on both sides of an edge if the squares of their distances from their mean sum
// up to more than kNoiseOfSides times the sum of their variances. The pixel is on the edge itself
// if its variance is more than kNoiseOfEdge times the mean of theirs.
inline constexpr double kNoiseOfSides = 2, kNoiseOfEdge = 9;
inline constexpr double kEnoughNeighbours = 8;  // with so many the own mean of a pixel is not needed

// An outlier has a part in the mean of its surroundings. This share of the square of that part is
// added to the squared error. It would be 2/3 if all outliers were equal. But the error of
// log-normal samples is predicted too low as it is, and 1/2 would lower it by another 9 %; this
// share lowers it by 4 %.
inline constexpr double kOwnPart = 0.15;
// The weight of an outlier's dimmer replicate for each sample of the pixel, where that of a
// neighbour is 1.
inline constexpr double kDimmerWeight = 0.125;

template <class Real>
struct Estimate {
  Real mean{};
  Real squared_error{};  // expected squared error of the mean
  Real disagreement{};   // squared; of neighbours on both sides of an edge, beyond what noise explains
};

/// Estimates the expectation of a pixel from the neighbours that may have the same, given its
/// noise.
/// own_share: factor for its own variance estimate where that multiplies itself
template <class Real>
EK_INLINE void expectation(const Real& mean, const Real& variance, const Neighbours<Real, Real>& near,
                           double candidates, double own_share, Estimate<Real>& found) {
  const Real count = near.count, none{}, own_left = 1 - count / kEnoughNeighbours;
  const Real own_weight = own_left > none ? own_left : none;
  const Real weight = count + own_weight, own_part = own_weight / weight;
  const Real own_noise = own_part * own_part * own_share * variance;
  // The fewer neighbours were chosen, the more the choice follows the error of the pixel itself.
  const Real pull = 1 - count / candidates;
  const auto has_any = count > none;
  const Real pulled_noise = has_any ? pull * pull * near.noise / count : none;
  const Real spread = has_any ? near.squares - near.sum * near.sum / count : none;
  found.squared_error =
      (spread > none ? spread : none) / (weight * weight) + (own_noise < pulled_noise ? pulled_noise : own_noise);
  const Real sides = spread > kNoiseOfSides * near.noise ? (spread - kNoiseOfSides * near.noise) / count : none;
  const Real step = near.sum / weight, step2 = step * step;
  found.mean = mean + step;
  // Neighbours of a pixel that is on the edge itself may all be from one side.
  const auto is_one_side = (count * variance > kNoiseOfEdge * near.noise) & (sides < step2);
  found.disagreement = is_one_side ? step2 : sides;
}

/// Improves the expectation of a pixel that is an outlier by what the pixel itself tells.
///
/// The dimmer of two replicates does not have the outlier's bright sample. So its mean tells
/// whether the pixel differs from its surroundings, and the more samples it has, the more it
/// counts.
///
/// The surroundings of an outlier may all be black so far, and yet their expectation is not zero:
/// what fell upon this pixel could have fallen upon them. So the squared error grows with the part
/// that this pixel has in the mean of the surroundings. Let outliers of a size x fall upon n
/// pixels. Their number has a Poisson distribution, and with K others beside one that was met,
///   (n / x)^2 / ((K + 1) (K + 2)) = (n / x)^2 / (K^2 + 3 K + 2)
/// estimates 1 / mu^2 without bias [Chen 1975]. What inverse_scale() makes of the neighbours alone
/// has K^2 + 3 K as its denominator. This adds the 2 that is missing (if kOwnPart were 2/3), which
/// bounds what an outlier can add.
///
/// mean           of the pixel
/// dimmer         mean of the dimmer replicate
/// dimmer_weight  weight of that mean, where a neighbour's is 1; 0 if there are not two replicates
/// count          neighbours from which the expectation was found
inline void add_own_evidence(double mean, double dimmer, double dimmer_weight, double count, Estimate<double>& found) {
  const double part = (mean - found.mean) / (count + 1);
  found.squared_error += kOwnPart * part * part;
  if (dimmer_weight > 0) found.mean += dimmer_weight / (count + dimmer_weight) * (dimmer - found.mean);
}

/// Estimates 1 / (mu^2 + eps), without bias to second order in the error of mu, and within 0 and
/// 2 / eps.
template <class Real>
EK_INLINE void inverse_scale(const Estimate<Real>& mu, Real& found) {
  const Real none{}, f = 1 / (mu.mean * mu.mean + kErrorEpsilon), relative = mu.squared_error * f;
  // Where the error is large, a small mean is no evidence of a small mu.
  const Real square = mu.mean * mu.mean + mu.squared_error;
  // f'' / 2 = c f^2 for f = 1 / (mu^2 + eps); c is between -1 and 3.
  const Real c = (3 * square - kErrorEpsilon) / (square + kErrorEpsilon);
  found = c > none ? f / (1 + c * relative) : f * (1 - c * relative / (1 + relative));
}

inline double inverse_scale(const Estimate<double>& mu) {
  double found = 0;
  return inverse_scale(mu, found), found;
}

/// The part of an error, which was divided by the scale of mu, that the correction to second order
/// makes up; at most all of it.
template <class Real>
EK_INLINE void part_of_correction(const Estimate<Real>& mu, const Real& scale, const Real& error, Real& found) {
  const Real f = 1 / (mu.mean * mu.mean + kErrorEpsilon), change = f > scale ? f - scale : scale - f;
  found = change < scale ? error * change / scale : error;
}

/// The part that an edge makes uncertain, by how much the scale changes from one side of it to the
/// other, to first order.
template <class Real>
EK_INLINE void part_of_edges(const Estimate<Real>& mu, const Real& error, Real& found) {
  const Real square = mu.mean * mu.mean, f = 1 / (square + kErrorEpsilon),
             change2 = 4 * square * f * f * mu.disagreement;
  found = error * change2 / (1 + change2);
}

}  // namespace eikon
