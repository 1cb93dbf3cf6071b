// SPDX-License-Identifier: Apache-2.0
// The standard streams, any of which may be closed when the process starts.
#pragma once

namespace eikon {

/// Opens /dev/null in the place of each standard stream that is closed: the next file that the
/// process opens would get its number, and then messages. To be called before any file is opened.
void open_standard_streams();

/// True if standard output was closed when open_standard_streams() was called, so that what is
/// written to it is lost.
[[nodiscard]] bool standard_output_was_closed();

}  // namespace eikon
