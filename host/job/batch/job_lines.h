// SPDX-License-Identifier: Apache-2.0
// The text of a batch: one command per line, in words as a POSIX shell makes them.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

struct JobLine {
  std::size_t line = 0;  // from 1; where it begins
  std::vector<std::string> words{};
  std::string error{};  // why there are no words; empty: there are
};

/// Splits a text into commands. Blanks separate words; '...', "..." and backslashes quote; a backslash at the end of a line
/// joins it with the next; # begins a comment where a word could begin. What a shell would expand or run ($ ` * ? [ ~ | & ; < > ( ),
/// unquoted) is an error of its line rather than something else than what the shell makes of it. Lines may end with CR LF.
/// source  [POSIX.1-2017, Shell Command Language, 2.2 and 2.3]
[[nodiscard]] std::vector<JobLine> split_jobs(std::string_view text);

/// The words as one line that split_jobs, and a shell, read as the same words.
[[nodiscard]] std::string quote(const std::vector<std::string>& words);

}  // namespace eikon
