// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <vector>

namespace eikon {

/// Path below kernels/ -> text, embedded at build time (generated).
const std::map<std::string, std::string>& embedded_kernels();

/// The text of files below kernels/, every include expanded in place, guarded headers once, with #line so that errors name the
/// real file and line.
/// Reads $EIKON_KERNEL_DIR instead of the embedded table when set. throws InternalError for a missing file.
std::string kernel_text(const std::vector<std::string>& entries);
/// The same for a text of the caller's own (a probe of the tests), called `name` in errors.
std::string expand_includes(const std::string& text, const std::string& name);

}  // namespace eikon
