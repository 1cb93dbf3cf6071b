// SPDX-License-Identifier: Apache-2.0
// Gives a render the pilot that is known of its image: from the file of --pilot, or from an earlier
// job of a batch.
#pragma once
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "job/log.h"
#include "job/prepare.h"
#include "render/film_record.h"
#include "render/render.h"

namespace eikon {

/// The pilots of a process, by the settings that decide them. Any thread may call it.
class PilotCache {
 public:
  [[nodiscard]] std::optional<Pilot> find(const std::string& key);
  void put(const std::string& key, const Pilot& pilot);

 private:
  std::mutex mutex_;
  std::map<std::string, Pilot> pilots_;
};

class PilotKeeper {
 public:
  /// file     of --pilot; empty: none
  /// outputs  of the render
  /// throws UsageError when the file is standard output or an output; InputError when it neither
  /// exists nor can be written
  PilotKeeper(std::string file, const std::vector<std::filesystem::path>& outputs, Log log);

  /// Reads the file if there is one, and says so, unless quiet, if the image has no pilot. To be
  /// called before the scene is released.
  /// throws InputError if it is damaged or of another image, and names what differs
  void begin(const Prepared& prepared, const Execution& execution, bool quiet);
  /// cache: to look in and add to; null: none
  void attach(RenderHooks& hooks, PilotCache* cache);
  /// False if the file could not be written.
  [[nodiscard]] bool as_asked() const { return as_asked_; }

 private:
  std::string file_;
  Log log_;
  std::vector<ImageSetting> settings_;
  std::string key_;
  std::optional<Pilot> read_;
  bool as_asked_ = true;

  void write(const Pilot& pilot);
};

}  // namespace eikon
