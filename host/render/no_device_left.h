// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <utility>

#include "core/error.h"
#include "render/render.h"

namespace eikon {

/// render() throws this when no device is left but some samples are done; `done` is as of an
/// interrupted render.
struct NoDeviceLeft : DeviceError {
  NoDeviceLeft(const std::string& why, RenderOutput output)
      : DeviceError(why), done(std::make_shared<RenderOutput>(std::move(output))) {}
  std::shared_ptr<RenderOutput> done;  // exceptions are copied
};

}  // namespace eikon
