// SPDX-License-Identifier: Apache-2.0
// Which layout of the tree a device traces rays through: the one asked for, the usual one for devices of its kind, or the fastest
// of those measured on it with the scene's own rays. The image is the same in all.
#pragma once
#include <string>
#include <vector>

#include "device/device.h"
#include "pack/pack.h"
#include "pack/settings.h"
#include "wavefront/wavefront.h"

namespace eikon {

struct LayoutRate {
  std::string layout;
  double mrays_per_s = 0;
};

struct LayoutChoice {
  std::string layout;             // of tree_layouts(), or "none"
  std::string why;                // "asked for", "usual for 16 lanes", ...
  std::vector<LayoutRate> rates;  // what was measured, if anything
};

/// `--layout` takes it beside the names of layouts: measure, however short the render.
inline const char* const kProbeLayouts = "probe";

/// What to do about a device, before it is touched.
struct LayoutPlan {
  std::string layout;                // asked for, or usual
  std::string why;                   // that one
  std::vector<std::string> measure;  // which to measure, to take the fastest; empty: none
};

/// Measured is what was not asked for by name, if `--layout probe` asks for that, or if it is likely to pay: on devices that run
/// one lane, in renders far longer than the measurement. For CPU devices (in chunks) the usual layout is
/// within some percent of the best in the scenes that were measured.
/// two_level: only layouts that have them (placed_meshes.h)
/// config: of configure(), with execution.layout if it is a layout; rays: that the render is expected to trace
[[nodiscard]] LayoutPlan plan_layout(const WavefrontConfig& config, const Execution& execution, std::size_t triangles,
                                     double rays, bool two_level = false);

/// The fastest of `rates`, but `usual` where nothing is faster by more than timing errs.
[[nodiscard]] LayoutChoice fastest_layout(std::vector<LayoutRate> rates, const std::string& usual);

/// `execution` with its layout as configure() takes it: kProbeLayouts is none.
[[nodiscard]] Execution without_probe(const Execution& execution);

/// Chooses for a device and adds the tree of that layout to `packed`. Nothing is kept from one render to the next: what was
/// measured holds for this device, driver and scene, and is a small part of the renders that it is done for.
/// throws UsageError for a layout that does not exist
LayoutChoice choose_layout(const DeviceInfo& info, PackedScene& packed, const Features& features,
                           const Settings& settings, const Execution& execution);

}  // namespace eikon
