// SPDX-License-Identifier: Apache-2.0
// How a measured material's table lies in memory: floats, behind those of the textures, from MaterialExtension.measured_table on.
// Host (scene/measured_table.cpp) and kernels (bsdf/measured.h) share it.
#ifndef EK_SHARED_MEASURED_H
#define EK_SHARED_MEASURED_H

// Cells of the three angles of Rusinkiewicz, as MERL's files have them: theta_h by the square root of its share of a quarter
// turn, theta_d evenly over a quarter turn, phi_d evenly over half a turn. Values stand for the cells' middles.
#define EK_MEASURED_THETA_H 90
#define EK_MEASURED_THETA_D 90
#define EK_MEASURED_PHI_D 180
#define EK_MEASURED_CELLS (EK_MEASURED_THETA_H * EK_MEASURED_THETA_D * EK_MEASURED_PHI_D)

// Views that half vectors are sampled for, evenly spaced in the cosine of wo.
#define EK_MEASURED_VIEWS 32

// First 1 - cos of the bounds of theta_h's cells.
#define EK_MEASURED_EDGES (EK_MEASURED_THETA_H + 1)
// Then of each view: the probability of sampling a half vector, and of theta_h's cells the cumulative probability, from 0 to 1,
// and the density per sr.
#define EK_MEASURED_VIEW_CUMULATIVE 1
#define EK_MEASURED_VIEW_DENSITY (EK_MEASURED_VIEW_CUMULATIVE + EK_MEASURED_EDGES)
#define EK_MEASURED_VIEW_WORDS (EK_MEASURED_VIEW_DENSITY + EK_MEASURED_THETA_H)
// Then the values, R, G, B of each cell, phi_d fastest, theta_h slowest.
#define EK_MEASURED_VALUES (EK_MEASURED_EDGES + EK_MEASURED_VIEWS * EK_MEASURED_VIEW_WORDS)
#define EK_MEASURED_WORDS (EK_MEASURED_VALUES + 3 * EK_MEASURED_CELLS)

// What `eikon measure` may find of a material that no table holds (measure.cl).
#define EK_FOUND_DELTA 1u         // a perfect mirror
#define EK_FOUND_TRANSMISSION 2u  // light passes
#define EK_FOUND_NOT_FINITE 4u

#endif
