// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "core/error.h"
#include "render/render.h"

namespace eikon {

/// What render() throws when no device is left, if samples were done by then: as of a render that was interrupted.
struct NoDeviceLeft : DeviceError {
  NoDeviceLeft(const std::string& why, RenderOutput output)
      : DeviceError(why), done(std::make_shared<RenderOutput>(std::move(output))) {}
  std::shared_ptr<RenderOutput> done;  // exceptions are copied
};

}  // namespace eikon
