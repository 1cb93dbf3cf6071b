// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "job/report.h"
#include "image/image.h"

namespace eikon {
namespace {

struct CompareOptions {
  std::string test, reference, png;
  bool json = false;
  double fail_above = -1;
};

ExitCode compare_command(const CompareOptions& options) {
  require_writable({options.png}, options.reference);
  const Image test = read_exr(options.test), reference = read_exr(options.reference);
  Comparison result = compare_images(test, reference);
  result.flip = flip(test, reference);
  if (!options.png.empty()) write_png(options.png, difference_image(test, reference), 0);
  if (options.json) {
    const nlohmann::json out = {{"mse", result.mse},
                                {"relmse", result.relmse},
                                {"mape", result.mape},
                                {"ratio_of_means", result.ratio_of_means},
                                {"nonfinite", result.nonfinite},
                                {"flip", result.flip ? nlohmann::json(*result.flip) : nlohmann::json(nullptr)}};
    fmt::print("{}\n", out.dump());
  } else {
    fmt::print("MSE {:.6e}\nrelMSE {:.6e}\nMAPE {:.6e}\nratio of means {:.6f}\n", result.mse, result.relmse,
               result.mape, result.ratio_of_means);
    fmt::print("FLIP {}\n",
               result.flip ? fmt::format("{:.6f}", *result.flip) : "not available (pip install flip-evaluator)");
    if (result.nonfinite > 0) fmt::print("{} values are not finite and were left out\n", result.nonfinite);
  }
  // Values that could not be compared are no success; nor is NaN below any bound.
  const bool within = result.relmse <= options.fail_above && result.nonfinite == 0;
  return options.fail_above >= 0 && !within ? ExitCode::not_as_asked : ExitCode::done;
}

}  // namespace

void add_compare(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand(
      "compare", "how far an image is from a reference: MSE, relMSE, MAPE, ratio of means, HDR-FLIP");
  command->add_option("TEST", options->test, "OpenEXR image")->required();
  command->add_option("REF", options->reference, "OpenEXR image of the same size")->required();
  command->add_flag("--json", options->json, "one line of JSON");
  command->add_option("--png", options->png, "picture of the difference");
  command->add_option("--fail-above", options->fail_above, "exit code 1 when relMSE is larger")
      ->check(between(0.0, 1e30));
  command->footer("Example:\n  eikon compare test.exr reference.exr --png difference.png --fail-above 0.01");
  command->callback([options, &chosen] { chosen = [options] { return compare_command(*options); }; });
}

}  // namespace eikon
