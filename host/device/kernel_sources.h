// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

/// Path below kernels/ -> text, embedded at build time (generated).
const std::map<std::string, std::string>& embedded_kernels();

/// Returns the text of files below kernels/ with every include expanded in place and guarded
/// headers once. #line directives make errors name the real file and line. $EIKON_KERNEL_DIR, when
/// set, replaces the embedded table. throws UsageError for a missing file of it
std::string kernel_text(const std::vector<std::string>& entries);
/// The same for a text of the caller (a probe of a test), called `name` in errors.
std::string expand_includes(const std::string& text, const std::string& name);

/// The text as a compiler sees it: without comments, #line directives, indentation and empty lines.
/// Drivers keep compiled programs by their text, so these stay valid where only comments have
/// changed.
std::string bare_text(std::string_view text);

}  // namespace eikon
