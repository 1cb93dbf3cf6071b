// SPDX-License-Identifier: Apache-2.0
#include "job/batch/shell_words.h"

#include <fmt/format.h>

namespace eikon {
namespace {

constexpr std::string_view kExpanded = "$`*?[";  // anywhere in a word
constexpr std::string_view kOperators = "|&;<>()";

/// Reads a text from front to back.
class Splitter {
 public:
  explicit Splitter(std::string_view text) : text_(text) {
    if (text_.substr(0, 3) == "\xef\xbb\xbf") text_.remove_prefix(3);  // byte order mark
  }

  std::vector<JobLine> split() {
    while (at_ < text_.size()) {
      job_ = {.line = line_};
      word_.clear();
      in_word_ = false;
      while (at_ < text_.size() && !at_end_of_line() && job_.error.empty()) step();
      end_word();
      if (!job_.error.empty()) job_.words.clear();
      if (!job_.words.empty() || !job_.error.empty()) jobs_.push_back(std::move(job_));
      skip_line();
    }
    return std::move(jobs_);
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0, line_ = 1;
  std::vector<JobLine> jobs_;
  JobLine job_;
  std::string word_;
  bool in_word_ = false;  // also in an empty one, ''

  /// Returns the character so many places ahead without taking it; a newline at the end of the
  /// text.
  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\n';
  }
  [[nodiscard]] std::size_t end_of_line(std::size_t ahead = 0) const {  // characters that end the line here; 0: none
    if (peek(ahead) == '\n') return 1;
    return peek(ahead) == '\r' && peek(ahead + 1) == '\n' ? 2 : 0;
  }
  [[nodiscard]] bool at_end_of_line() const { return end_of_line() > 0; }

  void skip_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    if (at_ < text_.size()) at_ += 1, line_ += 1;
  }
  void end_word() {
    if (in_word_) job_.words.push_back(std::move(word_));
    word_.clear();
    in_word_ = false;
  }
  void take() {
    const char c = text_[at_++];
    if (c == '\0') job_.error = "there is a character NUL in the line";
    word_ += c;
    in_word_ = true;
  }
  void refuse(char c, const char* what) {
    job_.error = fmt::format("'{}' is not {} here; quote it if it is meant: '{}'", c, what, c);
  }

  void step() {
    const char c = peek();
    if (c == ' ' || c == '\t') return end_word(), void(++at_);
    if (c == '#' && !in_word_) {
      while (at_ < text_.size() && !at_end_of_line()) ++at_;
      return;
    }
    if (c == '\'') return single_quoted();
    if (c == '"') return double_quoted();
    if (c == '\\') return backslash();
    if (kExpanded.find(c) != std::string_view::npos || (c == '~' && !in_word_)) return refuse(c, "expanded");
    if (kOperators.find(c) != std::string_view::npos) return refuse(c, "an operator");
    take();
  }
  void backslash() {
    ++at_;
    if (at_ >= text_.size()) {
      job_.error = "the last line ends with a backslash, which joins it with the next";
    } else if (const std::size_t end = end_of_line()) {
      at_ += end, line_ += 1;
    } else {
      take();
    }
  }
  void single_quoted() {
    ++at_, in_word_ = true;
    while (peek() != '\'' && !at_end_of_line()) take();
    close('\'');
  }
  void double_quoted() {
    ++at_, in_word_ = true;
    while (job_.error.empty() && peek() != '"' && !at_end_of_line()) {
      const char c = peek();
      if (c == '$' || c == '`') return refuse(c, "expanded");
      if (c == '\\' && std::string_view("$`\"\\").find(peek(1)) != std::string_view::npos) {
        ++at_;
      } else if (c == '\\' && at_ + 1 < text_.size() && end_of_line(1) > 0) {
        at_ += 1 + end_of_line(1), line_ += 1;
        continue;
      }
      if (at_ < text_.size()) take();
    }
    if (job_.error.empty()) close('"');
  }
  void close(char quote) {
    if (peek() == quote && at_ < text_.size())
      ++at_;
    else if (job_.error.empty())
      job_.error = fmt::format("there is no closing {} before the end of the line", quote);
  }
};

}  // namespace

std::vector<JobLine> split_jobs(std::string_view text) { return Splitter(text).split(); }

std::string quote(const std::vector<std::string>& words) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:,+=@%^";
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) line += c == '\'' ? "'\\''" : std::string(1, c);
    line += '\'';
  }
  return line;
}

}  // namespace eikon
