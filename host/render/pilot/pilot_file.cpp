// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/pilot_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <span>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/source_file.h"
#include "io/text.h"
#include "io/xxhash64.h"

namespace eikon {
namespace {

static_assert(std::endian::native == std::endian::little, "words of the table would have to be turned round");

constexpr std::string_view kName = "eikon pilot ";
constexpr std::string_view kFirstLine = "eikon pilot 3\n";
constexpr std::string_view kSetting = "setting ";
constexpr std::array<const char*, kAimKinds> kAimDensityFactor = {"gain of cones", "gain of discs"};  // in the file
constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 30;
constexpr std::size_t kMaxWords = kMaxBytes / sizeof(std::uint32_t);

std::uint64_t hash_of(std::string_view bytes) {
  return xxhash64(std::as_bytes(std::span(bytes.data(), bytes.size())), 0);
}

void append(std::string& bytes, const std::vector<std::uint32_t>& words) {
  bytes.append(reinterpret_cast<const char*>(words.data()), words.size() * sizeof(std::uint32_t));
}

[[noreturn]] void refuse_damaged() { throw InputError("it is damaged, or not all of it was copied"); }

/// The lines of the text, without those of settings: "NAME: VALUE".
class Figures {
 public:
  void add(std::string_view line) {
    const std::size_t colon = line.find(": ");
    if (colon == std::string_view::npos) refuse_damaged();
    values_.emplace(line.substr(0, colon), line.substr(colon + 2));
  }
  [[nodiscard]] std::string text(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) refuse_damaged();
    return found->second;
  }
  template <class Number>
  [[nodiscard]] Number number(const std::string& name, Number most) const {
    const auto value = number_in<Number>(text(name));
    if (!value || !(*value >= Number{} && *value <= most)) refuse_damaged();
    return *value;
  }

 private:
  std::map<std::string, std::string> values_;
};

/// Takes words from the front of the bytes.
std::vector<std::uint32_t> take(std::string_view& bytes, std::size_t count) {
  if (bytes.size() / sizeof(std::uint32_t) < count) refuse_damaged();
  std::vector<std::uint32_t> words(count);
  if (count > 0) std::memcpy(words.data(), bytes.data(), count * sizeof(std::uint32_t));
  bytes.remove_prefix(count * sizeof(std::uint32_t));
  return words;
}

Pilot pilot_of(const Figures& figures, std::string_view table_bytes) {
  constexpr double kAny = std::numeric_limits<double>::max();
  Pilot pilot;
  PilotReport& report = pilot.report;
  report.loaded = true;
  report.arithmetic = figures.text("arithmetic");
  report.guiding_paths = figures.number<std::uint64_t>("paths", std::numeric_limits<std::uint64_t>::max());
  report.guiding_cells = figures.number<std::uint64_t>("cells", kMaxWords);
  report.guiding_gain = figures.number<double>("gain", kAny);
  report.roulette_depth = figures.number<std::uint32_t>("roulette depth", 2);
  report.light_trial_paths = figures.number<std::uint64_t>("paths of the trial of light paths", std::uint64_t{1} << 48);
  report.light_path_count = figures.number<std::uint64_t>("light paths of each sample", std::uint64_t{1} << 31);
  report.light_path_gain = figures.number<double>("gain by light paths", kAny);
  report.light_aim_gain = figures.number<double>("gain by aim", kAny);
  LightAim aim;
  for (std::size_t kind = 0; kind < aim.density_factor.size(); ++kind)
    aim.density_factor[kind] = figures.number<float>(kAimDensityFactor[kind], std::numeric_limits<float>::max());
  aim.words = take(table_bytes, figures.number<std::size_t>("words of aim", kMaxWords));
  if (!aim.words.empty()) {
    if (!aim.is_sound()) refuse_damaged();
    pilot.light_aim = std::make_shared<const LightAim>(std::move(aim));
  }
  GuideTable table;
  table.roulette_depth = report.roulette_depth;
  table.scale = figures.number<float>("scale", std::numeric_limits<float>::max());
  table.slots = take(table_bytes, figures.number<std::size_t>("words of slots", kMaxWords));
  table.cells = take(table_bytes, figures.number<std::size_t>("words of cells", kMaxWords));
  if (!table_bytes.empty()) refuse_damaged();
  if (report.roulette_depth == 0) return pilot;
  if (!table.is_sound()) refuse_damaged();
  report.guiding_digest = table.digest();
  pilot.table = std::make_shared<const GuideTable>(std::move(table));
  return pilot;
}

}  // namespace

std::vector<ImageSetting> pilot_settings_of(const Scene& scene, Settings settings, const FilmLayout& layout) {
  settings.seed = 0;
  settings.replicate_bits = 0;
  return image_settings(scene, settings, layout);
}

std::string to_bytes(const Pilot& pilot, const std::vector<ImageSetting>& settings) {
  const PilotReport& report = pilot.report;
  GuideTable none;
  none.slots.clear();
  const GuideTable& table = pilot.table ? *pilot.table : none;
  const LightAim even{.words = {}};
  const LightAim& aim = pilot.light_aim ? *pilot.light_aim : even;
  std::string bytes(kFirstLine);
  for (const ImageSetting& setting : settings)
    bytes += fmt::format("{}{}: {}\n", kSetting, setting.name, setting.value);
  bytes += fmt::format("arithmetic: {}\npaths: {}\ncells: {}\ngain: {}\n", report.arithmetic, report.guiding_paths,
                       report.guiding_cells, report.guiding_gain);
  bytes +=
      fmt::format("paths of the trial of light paths: {}\nlight paths of each sample: {}\ngain by light paths: {}\n",
                  report.light_trial_paths, report.light_path_count, report.light_path_gain);
  bytes += fmt::format("gain by aim: {}\n", report.light_aim_gain);
  for (std::size_t kind = 0; kind < aim.density_factor.size(); ++kind)
    bytes += fmt::format("{}: {}\n", kAimDensityFactor[kind], aim.density_factor[kind]);
  bytes += fmt::format("words of aim: {}\nroulette depth: {}\nscale: {}\nwords of slots: {}\nwords of cells: {}\n\n",
                       aim.words.size(), report.roulette_depth, table.scale, table.slots.size(), table.cells.size());
  append(bytes, aim.words);
  append(bytes, table.slots);
  append(bytes, table.cells);
  const std::uint64_t hash = hash_of(bytes);
  bytes.append(reinterpret_cast<const char*>(&hash), sizeof hash);
  return bytes;
}

Pilot parse_pilot(std::string_view bytes, const std::vector<ImageSetting>& settings) {
  if (!bytes.starts_with(kName)) throw InputError("it is no file of --pilot");
  std::uint64_t hash = 0;
  if (bytes.size() < kName.size() + sizeof hash) refuse_damaged();
  std::string_view rest = bytes.substr(0, bytes.size() - sizeof hash);
  std::memcpy(&hash, bytes.data() + rest.size(), sizeof hash);
  if (hash != hash_of(rest)) refuse_damaged();
  if (!rest.starts_with(kFirstLine)) throw InputError("another version of eikon wrote it");
  rest.remove_prefix(kFirstLine.size());

  std::vector<ImageSetting> found;
  Figures figures;
  for (;;) {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) refuse_damaged();
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end + 1);
    if (line.empty()) break;
    if (!line.starts_with(kSetting)) {
      figures.add(line);
      continue;
    }
    line.remove_prefix(kSetting.size());
    const std::size_t colon = line.find(": ");
    if (colon == std::string_view::npos) refuse_damaged();
    found.push_back({std::string(line.substr(0, colon)), std::string(line.substr(colon + 2))});
  }
  if (const auto what = difference(settings, found)) throw InputError(*what);
  return pilot_of(figures, rest);
}

void write_pilot(const std::filesystem::path& file, const Pilot& pilot, const std::vector<ImageSetting>& settings) {
  const std::string bytes = to_bytes(pilot, settings);
  AtomicFile out(file);
  out.write(bytes.data(), bytes.size());
  out.commit();
}

Pilot read_pilot(const std::filesystem::path& file, const std::vector<ImageSetting>& settings) {
  try {
    const Bytes bytes = read_regular_file(file, kMaxBytes);
    return parse_pilot({reinterpret_cast<const char*>(bytes.data.get()), bytes.size}, settings);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("cannot use the pilot in \"{}\": {}; remove the file, or name another one that does not "
                    "exist, and a pilot is made",
                    file.string(), error.what()));
  }
}

}  // namespace eikon
