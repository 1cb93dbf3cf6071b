// SPDX-License-Identifier: Apache-2.0
// Layout of a measured material's table, which host (scene/measured_table.cpp) and kernels
// (bsdf/measured.h) share: floats behind the texels of the textures, from
// MaterialExtension.measured_table on.
#ifndef EK_SHARED_MEASURED_H
#define EK_SHARED_MEASURED_H

// Cells of Rusinkiewicz's three angles, as in MERL's files: uniform in the square root of theta_h
// over a quarter turn, in theta_d over a quarter turn, and in phi_d over half a turn. Values are at
// cell centres.
#define EK_MEASURED_THETA_H 90
#define EK_MEASURED_THETA_D 90
#define EK_MEASURED_PHI_D 180
#define EK_MEASURED_CELLS (EK_MEASURED_THETA_H * EK_MEASURED_THETA_D * EK_MEASURED_PHI_D)

// Number of view directions that half vectors are sampled for, evenly spaced in the cosine of wo.
#define EK_MEASURED_VIEWS 32

// The table begins with 1 - cos of the bounds of theta_h's cells.
#define EK_MEASURED_EDGES (EK_MEASURED_THETA_H + 1)
// For each view it goes on with the probability of sampling a half vector, the cumulative
// probabilities of theta_h's cells from 0 to 1, and their densities per sr.
#define EK_MEASURED_VIEW_CUMULATIVE 1
#define EK_MEASURED_VIEW_DENSITY (EK_MEASURED_VIEW_CUMULATIVE + EK_MEASURED_EDGES)
#define EK_MEASURED_VIEW_WORDS (EK_MEASURED_VIEW_DENSITY + EK_MEASURED_THETA_H)
// The values R, G, B of each cell follow, phi_d fastest and theta_h slowest.
#define EK_MEASURED_VALUES (EK_MEASURED_EDGES + EK_MEASURED_VIEWS * EK_MEASURED_VIEW_WORDS)
#define EK_MEASURED_WORDS (EK_MEASURED_VALUES + 3 * EK_MEASURED_CELLS)

// Properties of a material that `eikon measure` finds and no table can hold (probe/measure.cl).
#define EK_FOUND_DELTA 1u         // a perfect mirror
#define EK_FOUND_TRANSMISSION 2u  // it transmits light
#define EK_FOUND_NOT_FINITE 4u

#endif
