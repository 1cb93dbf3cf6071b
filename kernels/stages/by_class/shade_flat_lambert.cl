// SPDX-License-Identifier: Apache-2.0
// Stage `shade` where surfaces are flat and exactly Lambert, on GPU devices, in scenes that have
// others too.
#include "stages/by_class/shade_class.h"

EK_SHADE_CLASS(shade_flat_lambert, SHADING_FLAT_LAMBERT)
