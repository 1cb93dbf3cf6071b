// SPDX-License-Identifier: Apache-2.0
// Private to host/device: what eikon leaves out of PoCL's binaries. Beside the machine code of each
// kernel they hold the whole program in LLVM's bitcode, which PoCL parses whenever it opens one,
// and which it needs for kernels that have no machine code yet, and for nothing else. Parsing takes
// 10 to 20 ms of a program; everything else, half a millisecond.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace eikon {

/// Returns a binary with the same kernels and an empty program. PoCL unpacks it into a folder of
/// its own, beside that of the whole binary. None: a kernel has no machine code, or PoCL writes
/// another format than 3.1 does [lib/CL/pocl_binary.c, format 9].
std::optional<std::string> without_bitcode(std::string_view binary);

/// Returns whether PoCL has unpacked the machine code of an opened binary, which it does not say.
/// It does not where the disk is full, say; and then it would end the process at the first run of a
/// kernel that it cannot compile either. True for other formats, of which the bitcode is still
/// there.
/// cache  the folder in which PoCL keeps what it compiles
bool is_unpacked(std::string_view binary, const std::filesystem::path& cache);

}  // namespace eikon
