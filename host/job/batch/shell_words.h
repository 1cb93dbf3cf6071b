// SPDX-License-Identifier: Apache-2.0
// Splits the text of a batch, one command per line, into the words that a POSIX shell would pass
// on; and quotes words so that such a split gives them back.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace eikon {

struct JobLine {
  std::size_t line = 0;  // where it begins, from 1
  std::vector<std::string> words{};
  std::string error{};  // why there are no words; empty if there are
};

/// Splits a text into commands. Blanks separate words; '...', "..." and backslashes quote; a
/// backslash at the end of a line joins it with the next; # begins a comment where a word could
/// begin. Unquoted characters that a shell would expand or act on ($ ` * ? [ ~ | & ; < > ( )) are
/// an error of their line, so that a line never means something else than in a shell. Lines may end
/// with CR LF.
/// source  [POSIX.1-2017, Shell Command Language, 2.2 and 2.3]
[[nodiscard]] std::vector<JobLine> split_jobs(std::string_view text);

/// Joins words to a line that split_jobs, and a shell, split into the same words.
[[nodiscard]] std::string quote(const std::vector<std::string>& words);

}  // namespace eikon
