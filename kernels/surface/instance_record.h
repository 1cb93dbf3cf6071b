// SPDX-License-Identifier: Apache-2.0
// The matrix of an instance's record, as instance.h takes it.
#ifndef EK_INSTANCE_RECORD_H
#define EK_INSTANCE_RECORD_H
#include "lanes/record_lanes.h"
#include "surface/instance.h"

EK_FN InstanceTransform instance_transform(InstanceMatrixLanes m) {
  const InstanceTransform to_world = {m.m_x, m.m_y, m.m_z, V3(m.t_x, m.t_y, m.t_z)};
  return to_world;
}

#endif
