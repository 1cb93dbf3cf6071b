// SPDX-License-Identifier: Apache-2.0
// `bench scene` measures error against time. One growing render is compared whenever its samples
// per pixel have doubled: its film then has the bits of a render of so many samples, and scene,
// tree and kernels are made once. The JSON is
//   {scene, scene_hash, size, seed, max_depth, features, devices: [..],
//    reference: {path, relmse_predicted} | null,
//    points: [{spp, relmse | null, relmse_predicted | null, relmse_interval | null,
//              ratio_of_means | null, seconds, seconds_from_start, samples_per_second,
//              efficiency | null}],
//    exponents: {samples: EXPONENT | null, seconds: EXPONENT | null}}
// EXPONENT is that of the error: {value, doubt, bend: {at, before: {value, doubt}, after: {value,
// doubt}} | null}; doubt is half of a 95 % interval, and a bend is where two exponents describe the
// points significantly better than one. `seconds` are those of rendering alone, `relmse` is against
// the reference, and `efficiency` is 1 / (error x seconds) of the measured error, or else of the
// predicted one.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.h"
#include "cli/flags.h"
#include "core/clock.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "instruments/power_law.h"
#include "job/goal.h"
#include "job/log.h"
#include "job/report/metadata.h"
#include "io/atomic_file.h"
#include "io/json_dump.h"
#include "io/text.h"
#include "job/file_identity.h"
#include "job/report/result_lines.h"

namespace eikon {
namespace {

struct BenchSceneOptions {
  SceneOptions scene;
  Execution execution;
  std::string reference, json;
  double time_s = 0;  // 0: no limit
};

struct Reference {
  Image image;
  Metadata metadata;
  std::string path;
};

struct Point {
  std::uint64_t spp = 0;
  std::optional<Comparison> measured;
  PredictedError predicted;
  double seconds = 0, from_start_s = 0;

  [[nodiscard]] std::optional<double> error() const {
    if (measured) return measured->relmse;
    return predicted.known && std::isfinite(predicted.hi) ? std::optional(predicted.relmse) : std::nullopt;
  }
};

bool same_matrix(const std::vector<double>& a, const std::vector<double>& b) {
  // The file has single precision.
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return std::abs(x - y) <= 1e-6 * (1 + std::abs(x)); });
}

/// Checks by its header that the reference is made of other samples: the same ones would hide their
/// error. throws UsageError if it is not; InputError if the header does not say which samples those
/// are
void require_other_samples(const Settings& settings, const Reference& reference) {
  const auto seed = reference.metadata.numbers.find("seed");
  const auto range = reference.metadata.strings.find("sampleRange");
  if (seed == reference.metadata.numbers.end() || range == reference.metadata.strings.end()) return;
  const std::vector<std::string> ends = split(range->second, ':');
  const auto begin = number_in<std::uint64_t>(ends.front()), end = number_in<std::uint64_t>(ends.back());
  if (ends.size() != 2 || !begin || !end)
    throw InputError(fmt::format("{}: its sampleRange is {}, not BEGIN:END; give a picture as eikon wrote it",
                                 reference.path, in_quotes(range->second)));
  if (seed->second == settings.seed && std::max(settings.sample_begin, *begin) < std::min(settings.sample_end, *end))
    throw UsageError(fmt::format("{}: the reference is made of the same samples, seed {}: give another --seed",
                                 reference.path, settings.seed));
}

/// Checks by its header that the reference is the picture that is rendered.
/// throws InputError if it is not
void require_same_picture(const Prepared& prepared, const Reference& reference) {
  const Settings& settings = prepared.settings;
  if (reference.image.width != settings.crop.width() || reference.image.height != settings.crop.height())
    throw InputError(fmt::format("{}: the reference has {} x {} pixels, the render {} x {}; give its --size or --crop",
                                 reference.path, reference.image.width, reference.image.height, settings.crop.width(),
                                 settings.crop.height()));
  if (reference.image.x0 != settings.crop.x0 || reference.image.y0 != settings.crop.y0)
    throw InputError(
        fmt::format("{}: the window of the reference begins at {},{}, that of the render at {},{}; give its --crop",
                    reference.path, reference.image.x0, reference.image.y0, settings.crop.x0, settings.crop.y0));
  for (const char* channel : {"R", "G", "B"})
    if (reference.image.plane(channel) == nullptr)
      throw InputError(fmt::format("{}: the reference has no channel {}", reference.path, channel));
  const Metadata ours = describe_picture(prepared);
  const auto differs = [&](const std::string& key, const std::string& theirs, const std::string& here) {
    return InputError(
        fmt::format("{}: the reference shows another picture: {} '{}', here '{}'", reference.path, key, theirs, here));
  };
  for (const auto& [key, value] : ours.strings) {
    const auto theirs = reference.metadata.strings.find(key);
    // The content identifies a scene, and the position a camera: their names may differ.
    if (key == "scene" || key == "camera" || theirs == reference.metadata.strings.end()) continue;
    if (theirs->second != value) throw differs(key, theirs->second, value);
  }
  for (const auto& [key, value] : ours.numbers) {
    const auto theirs = reference.metadata.numbers.find(key);
    if (theirs != reference.metadata.numbers.end() && theirs->second != value)
      throw differs(key, fmt::format("{}", theirs->second), fmt::format("{}", value));
  }
  for (const auto& [key, value] : ours.matrices) {
    const auto theirs = reference.metadata.matrices.find(key);
    if (theirs != reference.metadata.matrices.end() && !same_matrix(value, theirs->second))
      throw InputError(fmt::format("{}: the reference shows another picture: its camera stands or looks otherwise ({})",
                                   reference.path, key));
  }
}

nlohmann::json to_json(const Point& point, std::uint64_t pixels) {
  using nlohmann::json;
  const auto error = point.error();
  const PredictedError& predicted = point.predicted;
  return {{"spp", point.spp},
          {"relmse", point.measured ? json(point.measured->relmse) : json(nullptr)},
          {"relmse_predicted", predicted.known ? json(predicted.relmse) : json(nullptr)},
          {"relmse_interval", predicted.known ? json({predicted.lo, predicted.hi}) : json(nullptr)},
          {"ratio_of_means", point.measured ? json(point.measured->ratio_of_means) : json(nullptr)},
          {"seconds", point.seconds},
          {"seconds_from_start", point.from_start_s},
          {"samples_per_second", double(point.spp * pixels) / point.seconds},
          {"efficiency", error && *error > 0 ? json(1 / (*error * point.seconds)) : json(nullptr)}};
}

void print_rate(const nlohmann::json& row) {
  const auto number = [&](const char* key) {
    return row[key].is_null() ? std::string("-") : fmt::format("{:.3e}", row[key].get<double>());
  };
  fmt::print("{:>9} {:>11} {:>11} {:>11.3f} {:>11.3f} {:>12.3f} {:>11}\n", row["spp"].get<std::uint64_t>(),
             number("relmse"), number("relmse_predicted"), row["seconds"].get<double>(),
             row["seconds_from_start"].get<double>(), 1e-6 * row["samples_per_second"].get<double>(),
             number("efficiency"));
  std::fflush(stdout);
}

/// The results so far.
struct Results {
  std::vector<Point> points;
  nlohmann::json rows = nlohmann::json::array();
};

/// Compares the film whenever its samples per pixel have doubled, and ends the render when the time
/// is over.
class GrowingRender {
 public:
  GrowingRender(const BenchSceneOptions& options, const Settings& settings, const std::optional<Reference>& reference,
                Results& results)
      : options_(options), settings_(settings), reference_(reference), results_(results) {}

  Round next(const RoundEnd& now) {
    const std::uint64_t samples = now.done - settings_.sample_begin;
    if (samples == 0) return {.end = now.done + 1};
    compare(samples, now);
    // The next point takes about twice as long.
    if (options_.time_s > 0 && 2 * now.render_s > options_.time_s) return {.end = now.done};
    return {.end = std::min(settings_.sample_begin + 2 * samples, settings_.sample_end)};
  }

 private:
  void compare(std::uint64_t samples, const RoundEnd& now) {
    const double begin_s = process_seconds();
    Point point;
    point.spp = samples;
    point.seconds = now.render_s;
    point.from_start_s = begin_s - comparing_s_;
    if (reference_) point.measured = compare_images(to_image(now.film), reference_->image);
    point.predicted = now.film.predicted_error();
    results_.rows.push_back(to_json(point, settings_.crop.pixel_count()));
    print_rate(results_.rows.back());
    results_.points.push_back(point);
    comparing_s_ += process_seconds() - begin_s;
  }

  const BenchSceneOptions& options_;
  const Settings& settings_;
  const std::optional<Reference>& reference_;
  Results& results_;
  double comparing_s_ = 0;
};

/// The relMSE that the reference predicts of itself, if it does.
std::optional<double> own_error(const std::optional<Reference>& reference) {
  if (!reference) return std::nullopt;
  const auto found = reference->metadata.numbers.find("relmsePredicted");
  return found == reference->metadata.numbers.end() ? std::nullopt : std::optional(found->second);
}

/// Fits a power law to the error over `amount`, through the points whose error is known.
std::optional<PowerLaw> fall_of_error(const std::vector<Point>& points, double (*amount)(const Point&)) {
  std::vector<double> x, y;
  for (const Point& point : points)
    if (const auto error = point.error(); error && *error > 0 && amount(point) > 0) {
      x.push_back(amount(point));
      y.push_back(*error);
    }
  return fit_power_law(x, y);
}

nlohmann::json to_json(const std::optional<PowerLaw>& law) {
  using nlohmann::json;
  const auto exponent = [](const Exponent& e) { return json{{"value", e.value}, {"doubt", e.doubt}}; };
  if (!law) return nullptr;
  json out = exponent(law->exponent);
  out["bend"] = nullptr;
  if (law->bend)
    out["bend"] = {{"at", law->bend->x}, {"before", exponent(law->bend->before)}, {"after", exponent(law->bend->after)}};
  return out;
}

nlohmann::json to_json(const Prepared& prepared, const RenderReport& report, const std::optional<Reference>& reference,
                       const nlohmann::json& rows) {
  using nlohmann::json;
  const Settings& settings = prepared.settings;
  json devices = json::array();
  for (const DeviceReport& device : report.devices) devices.push_back(device.info.name);
  json out = {{"scene", prepared.scene->path.filename().string()},
              {"scene_hash", prepared.scene->hash},
              {"size", {settings.crop.width(), settings.crop.height()}},
              {"seed", settings.seed},
              {"max_depth", settings.max_depth},
              {"features", report.features},
              {"devices", devices},
              {"reference", nullptr},
              {"points", rows}};
  if (!reference) return out;
  const std::optional<double> error = own_error(reference);
  out["reference"] = {{"path", reference->path}, {"relmse_predicted", error ? json(*error) : json(nullptr)}};
  return out;
}

ExitCode bench_scene_command(const BenchSceneOptions& options) {
  require_writable({options.json},
                   {.scene = options.scene.scene, .files = {options.scene.environment.map, options.reference}});
  const Prepared prepared = prepare(options.scene, log_unless(true));
  std::optional<Reference> reference;
  if (!options.reference.empty()) {
    reference = Reference{read_exr(options.reference), read_metadata(options.reference), options.reference};
    require_same_picture(prepared, *reference);
    require_other_samples(prepared.settings, *reference);
  } else {
    print_to_stderr("eikon: no --ref: the error is the one that the render predicts of itself\n");
  }
  fmt::print("{:>9} {:>11} {:>11} {:>11} {:>11} {:>12} {:>11}\n", "spp", "relMSE", "predicted", "seconds", "from start",
             "Msamples/s", "1/(err s)");
  Results results;
  GrowingRender growing(options, prepared.settings, reference, results);
  const std::atomic<bool> stop{false};
  const auto next_round = [&](const RoundEnd& now) { return growing.next(now); };
  const RenderOutput done = render(*prepared.scene, prepared.settings, options.execution, stop, {.next_round = next_round});
  const auto by_samples = fall_of_error(results.points, [](const Point& point) { return double(point.spp); });
  const auto by_seconds = fall_of_error(results.points, [](const Point& point) { return point.seconds; });
  if (by_samples) fmt::print("exponent of the error over samples: {}\n", in_words(*by_samples));
  if (by_seconds) fmt::print("exponent of the error over seconds: {}\n", in_words(*by_seconds));
  if (!options.json.empty()) {
    nlohmann::json out = to_json(prepared, done.report, reference, results.rows);
    out["exponents"] = {{"samples", to_json(by_samples)}, {"seconds", to_json(by_seconds)}};
    // Paths on disk need not be UTF-8.
    write_text(options.json, dump_json(out, 2) + "\n");
  }
  if (!reference) return ExitCode::done;
  const Comparison& last = *results.points.back().measured;
  if (const auto error = own_error(reference); error && last.relmse < 10 * *error)
    print_to_stderr("eikon: the reference's own relMSE is {:.1e}: errors below {:.0e} are partly its noise\n", *error,
                    10 * *error);
  if (last.nonfinite == 0) return ExitCode::done;
  print_to_stderr("eikon: {} values of render or reference are not finite and were left out\n", last.nonfinite);
  return ExitCode::not_as_asked;
}

}  // namespace

void add_bench_scene(CommandFlags& bench, Command& chosen) {
  auto options = std::make_shared<BenchSceneOptions>();
  CommandFlags flags = bench.command(
      "scene", "measure error against time: a growing render, compared at 1, 2, 4, ... samples per pixel",
      "Example:\n  eikon render scenes/cornell.gltf -o ref.exr --size 256x256 --spp 16384 --seed 1\n"
      "  eikon bench scene scenes/cornell.gltf --size 256x256 --ref ref.exr --spp 512 --json error.json\n"
      "  tools/plot_error.py error.json -o error.svg\n\n" +
          environment_help());
  add_all_scene_flags(flags, options->scene);
  flags.hide({"--strict", "--aov"});
  add_execution_flags(flags, options->execution);
  flags.group("Output (- is standard output)");
  flags.text({"--ref", "FILE", "converged OpenEXR image of another seed [compare with the predicted error]"},
             options->reference);
  flags.number({"--time", "SECONDS", "most seconds of rendering, the first point excepted [until --spp]"}, options->time_s,
               1e-3, 1e9);
  flags.text({"--json", "FILE", "write the results as JSON; tools/plot_error.py draws them"}, options->json);
  flags.run(chosen, [options] {
    BenchSceneOptions read = *options;
    if (!read.scene.spp && read.time_s > 0) read.scene.spp = kMaxSppOfGoals;
    read_execution_environment(read.execution);
    return bench_scene_command(read);
  });
}

}  // namespace eikon
