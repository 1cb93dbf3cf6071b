// SPDX-License-Identifier: Apache-2.0
#include "view/server/redirect_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.h"

namespace eikon {

RedirectFile::RedirectFile(const std::string& address) {
  const std::string text = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>eikon view</title>"
      "<meta name=\"referrer\" content=\"no-referrer\"><meta http-equiv=\"refresh\" content=\"0; url={0}\">"
      "<a href=\"{0}\">eikon view</a></html>\n",
      address);
  const int file = open(path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  const bool is_whole = file >= 0 && write(file, text.data(), text.size()) == ssize_t(text.size());
  if (file >= 0) close(file);
  if (!is_whole) throw InputError(fmt::format("{}: cannot be written; the disk may be full", path().string()));
}

}  // namespace eikon
