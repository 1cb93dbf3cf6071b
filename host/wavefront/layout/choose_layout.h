// SPDX-License-Identifier: Apache-2.0
// Chooses the layout of the tree that a device traces rays through: the one asked for, the usual
// one for such devices, or the fastest on this device with the scene's own rays. The image is the
// same with all.
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

/// Value of --layout beside the names of layouts: measure, however short the render is.
inline const char* const kProbeLayouts = "probe";

/// The decision about a device before it is touched.
struct LayoutPlan {
  std::string layout;                // asked for, or usual
  std::string why;                   // the reason for it
  std::vector<std::string> measure;  // layouts to measure, of which the fastest is taken; empty: none
};

/// Unless a layout is asked for by name, layouts are measured if `--layout probe` asks for that, or
/// if it is likely to pay: on devices that run one lane, in renders far longer than the
/// measurement. On CPU devices (in chunks) the usual layout is within some percent of the best in
/// all scenes that were measured.
/// config     of configure(), with execution.layout if it is a layout
/// rays       that the render is expected to trace
/// two_level  true: only layouts with two levels (instanced_meshes.h)
[[nodiscard]] LayoutPlan plan_layout(const WavefrontConfig& config, const Execution& execution, std::size_t triangles,
                                     double rays, bool two_level = false);

/// The fastest of `rates`, or `usual` if nothing is faster by more than the error of timing.
[[nodiscard]] LayoutChoice fastest_layout(std::vector<LayoutRate> rates, const std::string& usual);

/// `execution` as configure() takes it: kProbeLayouts counts as no layout.
[[nodiscard]] Execution without_probe(const Execution& execution);

/// Chooses a layout for a device and adds its tree to `packed`. Nothing is kept from one render to
/// the next: measurements hold for this device, driver and scene, and take a small part of the
/// renders that they are made for.
/// throws UsageError for a layout that does not exist
LayoutChoice choose_layout(const DeviceInfo& info, PackedScene& packed, const Features& features,
                           const Settings& settings, const Execution& execution);

}  // namespace eikon
