// SPDX-License-Identifier: Apache-2.0
// The accelerators that --accel names. The table in accelerators.cpp has one line for each.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "accel/accel.h"

namespace eikon {

struct Accelerator {
  const char* name;    // --accel
  const char* layout;  // that programs are compiled for; nullptr: any of tree_layouts(), by device or --layout
  Accel (*build)(TriangleSoup triangles, const AccelOptions& options);
  const char* about;  // a few words for --help and tables
};

[[nodiscard]] std::span<const Accelerator> accelerators();
[[nodiscard]] std::vector<std::string> accelerator_names();

/// throws UsageError for a name that is not in the table
[[nodiscard]] const Accelerator& find_accelerator(const std::string& name);

/// The layout that only `accel` has; empty if it takes any of tree_layouts(), or is unknown.
[[nodiscard]] std::string own_layout(const std::string& accel);

}  // namespace eikon
