// SPDX-License-Identifier: Apache-2.0
// Rays through the production traversal headers on an OpenCL device.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "accel/accel.h"
#include "device/device.h"
#include "device/kernel_sources.h"
#include "kernels/probe.h"
#include "pack/frame.h"
#include "pack/pack.h"
#include "shared/records.h"

namespace eikon {

struct ProbeRay {
  std::array<float, 3> o{}, d{};
  float t_max = INFINITY;
  std::uint32_t left = EK_NO_HIT, goal = EK_NO_HIT;  // the triangles that it leaves and goes to
  float time = 0;                                    // share of the shutter's time that has passed
};

inline ProbeRay probe_ray(const glm::dvec3& origin, const glm::dvec3& dir, double t_max) {
  ProbeRay ray;
  for (int k = 0; k < 3; ++k) ray.o[std::size_t(k)] = float(origin[k]), ray.d[std::size_t(k)] = float(dir[k]);
  ray.t_max = float(t_max);
  return ray;
}

struct ProbeHit {
  float t = 0, u = 0, v = 0;
  std::uint32_t triangle = 0;
  std::uint32_t instance = 0;  // 1 + its number, of a scene in two levels; else 0
};

/// Rays that are none: `from` without a direction, or with numbers that are none or infinite.
inline std::vector<ProbeRay> rays_that_are_none(const ProbeRay& from) {
  std::vector<ProbeRay> all;
  const auto add = [&](const auto& change) {
    ProbeRay ray = from;
    change(ray);
    all.push_back(ray);
  };
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    for (std::size_t k = 0; k < 3; ++k) {
      add([&](ProbeRay& ray) { ray.o[k] = bad; });
      add([&](ProbeRay& ray) { ray.d[k] = bad; });
    }
    add([&](ProbeRay& ray) { ray.o.fill(bad); });
    add([&](ProbeRay& ray) { ray.d.fill(bad); });
  }
  add([](ProbeRay& ray) { ray.d.fill(0.0F); });
  add([](ProbeRay& ray) { ray.d.fill(-0.0F); });
  return all;
}

/// The production frame's part that traversal reads: bounds of the scene.
inline Frame frame_of(const std::vector<float>& soup) {
  float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (std::size_t i = 0; i < soup.size(); ++i) {
    lo[i % 3] = std::min(lo[i % 3], soup[i]);
    hi[i % 3] = std::max(hi[i % 3], soup[i]);
  }
  Frame frame{};
  if (soup.empty()) return frame;
  const auto center = [&](int k) { return 0.5F * lo[k] + 0.5F * hi[k]; };
  const auto half = [&](int k) { return std::max(hi[k] - center(k), center(k) - lo[k]); };
  frame.scene_center.x = center(0), frame.scene_center.y = center(1), frame.scene_center.z = center(2);
  frame.scene_half.x = half(0), frame.scene_half.y = half(1), frame.scene_half.z = half(2);
  return frame;
}

/// Defines that say which features there are: diffuse surfaces, and opacity if asked for.
inline std::map<std::string, std::string> feature_defines(bool opacity) {
  std::map<std::string, std::string> all = {
#define EK_LOBE(name, bit, traits) {"EK_HAS_" #name, "0"},
#define EK_LIGHT(name, bit) {"EK_HAS_" #name, "0"},
#define EK_SHAPE_KIND(name, bit) {"EK_HAS_" #name, "0"},
#define EK_OPTION(name) {"EK_HAS_" #name, "0"},
#define EK_AOV(name, channels) {"EK_HAS_" #name, "0"},
#include "shared/features.def"
  };
  all["EK_HAS_diffuse"] = "1";
  if (opacity) all["EK_HAS_opacity"] = "1";
  return all;
}

/// All that EK_LAYOUT can be: the trees, and none.
inline std::vector<std::string> every_layout() {
  std::vector<std::string> all = tree_layouts();
  all.push_back("none");
  return all;
}

/// One scene in one layout at one lane width.
class TraverseProbe {
 public:
  struct Options {
    std::string layout = "bvh16";
    int width = 16;
    bool portable = false;                            // without builtins of the host's processor
    bool coherent = false;                            // as camera rays are traced
    bool opacity = false;                             // each triangle may be of a material that rays pass
    std::vector<MaterialRecord> materials = {};       // with opacity
    std::vector<std::uint32_t> material_of = {};      // per triangle, with opacity
    // Flags per triangle: closest hits are of camera rays, with culling.
    std::vector<std::uint32_t> culled = {};
    std::optional<Accel> accel = {};                  // of this layout, instead of one built over the triangles
    std::map<std::string, std::string> defines = {};  // in place of those that tree and processor bring about
    std::string method = "bvh";                       // --accel
  };

  /// Every accelerator that is not the default, and every layout at the widths for which it has
  /// code of its own; those for wide devices also without builtins, and for rays that are traced
  /// together.
  static std::vector<Options> variants() {
    std::vector<Options> all;
    for (const std::string& name : accelerator_names()) {
      for (const int width : {1, 16}) {
        if (name == "bvh") continue;  // below
        Options o{"bvh2", width};
        o.method = name;
        all.push_back(std::move(o));
      }
    }
    const auto add = [&](const std::string& layout, int width, std::map<std::string, std::string> defines,
                         bool portable = false, bool coherent = false) {
      Options o{layout, width, portable, coherent};
      o.defines = std::move(defines);
      all.push_back(std::move(o));
    };
    for (const std::string& layout : tree_layouts()) {
      add(layout, 1, {});
      if (layout != "bvh8" && layout != "bvh16") {
        add(layout, 16, {});
        continue;
      }
      // Small trees would be traced as packets, with the rays of any kind; so each way is asked for
      // by its defines.
      for (const int width : {8, 16}) {
        add(layout, width, {{"EK_SMALL_TREE", "0"}});
        add(layout, width, {{"EK_SMALL_TREE", "0"}, {"EK_MEDIUM_TREE", "1"}, {"EK_LARGE_TREE", "1"}}, false, true);
      }
      add(layout, 16, {{"EK_SMALL_TREE", "1"}});
      add(layout, 16, {{"EK_SMALL_TREE", "0"}, {"EK_MEDIUM_TREE", "1"}});
      add(layout, 8, {{"EK_SMALL_TREE", "0"}, {"EK_NO_AVX512", "1"}});
      add(layout, 16, {{"EK_SMALL_TREE", "0"}}, true, false);
      add(layout, 16, {{"EK_SMALL_TREE", "0"}, {"EK_MEDIUM_TREE", "1"}, {"EK_LARGE_TREE", "1"}}, true, true);
    }
    return all;
  }

  /// Those of variants() between which the code differs by more than the width of its vectors:
  /// every accelerator and layout once, the wide ones in each way that rays go through them, and a
  /// tree through which the rays of several lanes go one by one. For features of which no code
  /// depends on the width, since Traverse compares all variants.
  static std::vector<Options> each_once() {
    std::vector<Options> all = variants();
    std::erase_if(all, [](const Options& o) {
      const bool wide = o.method == "bvh" && (o.layout == "bvh16" || o.layout == "bvh8");
      return wide ? o.portable || o.defines.contains("EK_NO_AVX512") ||
                        (o.width != 1 && o.width != (o.layout == "bvh16" ? 16 : 8))
                  : o.width != 1 && (o.method != "bvh" || o.layout != "bvh2");
    });
    return all;
  }

  [[nodiscard]] static std::string describe(const Options& options) {
    std::string text = (options.method == "bvh" ? "" : options.method + " ") + options.layout + " width " +
                       std::to_string(options.width) + (options.portable ? ", portable" : "") +
                       (options.coherent ? ", coherent" : "");
    for (const auto& [name, value] : options.defines) text += ", " + name + "=" + value;
    return text;
  }

  TraverseProbe(Device& device, const std::vector<float>& soup, const Options& options)
      : device_(device), accel_(options.accel ? *options.accel : build(soup, options)), coherent_(options.coherent) {
    auto features = feature_defines(options.opacity);
    if (!options.culled.empty()) features["EK_HAS_culling"] = "1";
    compile(std::move(features), options);
    std::vector<Triangle> triangles(soup.size() / 9 + 1);
    for (std::size_t i = 0; i < soup.size() / 9; ++i) {
      std::copy_n(&soup[9 * i], 9, &triangles[i].p0_x);
      if (!options.culled.empty()) triangles[i].flags = options.culled.at(i);
      if (!options.opacity) continue;
      triangles[i].material = options.material_of.at(i);
      triangles[i].flags |=
          (options.materials.at(options.material_of[i]).flags & (EK_MATERIAL_MASK | EK_MATERIAL_BLEND)) != 0
              ? EK_TRIANGLE_ALPHA_TESTED
              : 0;
    }
    if (options.opacity) {
      arguments_.set("materials", device.upload(options.materials));
      for (const char* absent :
           {"triangle_normals", "triangle_tangents", "triangle_colors", "material_extensions", "material_details", "textures", "texels"})
        arguments_.set(absent, device.upload(std::vector<MaterialRecord>(1)));
    }
    arguments_.set("frame", device.upload(std::vector<Frame>{frame_of(soup)}));
    arguments_.set("accel_nodes", device.upload(accel_.nodes));
    arguments_.set("accel_leaves", device.upload(accel_.leaves));
    arguments_.set("triangles", device.upload(triangles));
  }

  /// The same of a whole scene, whose features count; of `options` what is said of opacity does
  /// not.
  TraverseProbe(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
                const Options& options)
      : device_(device), accel_(build(scene, options)), coherent_(options.coherent) {
    compile(features.defines(), options, features.formula_code());
    arguments_.set("frame", device.upload(std::vector<Frame>{pack_frame(scene, settings)}));
    const auto upload = [&](const char* name, const auto& records) {
      using Record = typename std::decay_t<decltype(records)>::value_type;
      std::vector<Record> copy(records.begin(), records.end());
      if (copy.empty()) copy.resize(1);
      arguments_.set(name, device.upload(copy));
    };
    upload("accel_nodes", accel_.nodes);
    upload("accel_leaves", accel_.leaves);
    upload("triangles", scene.triangles);
    upload("triangle_normals", scene.normals);
    upload("triangle_tangents", scene.tangents);
    upload("triangle_colors", scene.colors);
    upload("materials", scene.materials);
    upload("material_extensions", scene.material_extensions);
    upload("material_details", scene.material_details);
    upload("textures", scene.textures);
    upload("shapes", scene.shapes);
    upload("instances", accel_.instances);
    upload("motion", scene.motion);
    upload("motion_nodes", accel_.motion_nodes);
    upload("motion_leaves", accel_.motion_leaves);
    upload("pose_triangles", scene.pose_triangles);
    two_level_ = features.has(Feature::instance);
    upload("diagnostics", std::vector<Diagnostics>(1));
    std::vector<std::uint32_t> texels(1);
    for (const auto& part : scene.texels) texels.insert(texels.end() - 1, part.begin(), part.end());
    arguments_.set("texels", device.upload(texels));
  }

  std::vector<ProbeHit> closest(const std::vector<ProbeRay>& rays) {
    const std::vector<float> words = run(closest_, rays);
    std::vector<ProbeHit> hits(rays.size());
    const std::size_t stride = words.size() / kHitWords;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      hits[i] = {words[i], words[stride + i], words[2 * stride + i],
                 std::bit_cast<std::uint32_t>(words[3 * stride + i]),
                 two_level_ ? std::bit_cast<std::uint32_t>(words[4 * stride + i]) : 0};
    }
    return hits;
  }

  std::vector<bool> any(const std::vector<ProbeRay>& rays) {
    const std::vector<float> words = run(any_, rays);
    std::vector<bool> hits(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = words[i] != 0;
    return hits;
  }

  [[nodiscard]] const Accel& accel() const { return accel_; }

 private:
  static constexpr std::size_t kChunk = 256, kHitWords = 5;

  void compile(std::map<std::string, std::string> defines, const Options& options, const std::string& behind = "") {
    ProgramOptions program;
    program.defines = std::move(defines);
    program.defines.merge(accel_.defines());
    program.defines["EK_WIDTH"] = std::to_string(options.width);
    program.defines["EK_CHUNK"] = std::to_string(kChunk);
    if (options.portable) program.defines["EK_PORTABLE"] = "1";
    program.defines["EK_OUT_OF_LINE"] = "1";  // the same bits, and compiled in half the time (probe.cpp)
    for (const auto& [name, value] : options.defines) program.defines[name] = value;
    const Program& built = test::program_of(device_, kernel_text({"probe/trace_rays.cl"}) + behind, program);
    closest_ = built.kernel("trace_closest");
    any_ = built.kernel("trace_any");
  }

  static AccelOptions accel_options(const Options& probe) {
    AccelOptions options;
    options.accel = probe.method;
    options.layout = probe.layout;
    return options;
  }
  static Accel build(const std::vector<float>& soup, const Options& probe) {
    return build_accel({soup}, accel_options(probe));
  }
  static Accel build(const PackedScene& scene, const Options& probe) {
    if (!scene.motion.empty()) return build_over_time(scene, accel_options(probe));
    if (scene.instances.empty()) return build_accel(soup_of(scene), accel_options(probe));
    return build_two_level(
        {soup_of(scene), scene.shapes.size(), scene.stored_meshes, scene.instances, scene.instance_boxes},
        accel_options(probe));
  }

  std::vector<float> run(Kernel& kernel, const std::vector<ProbeRay>& rays) {
    const std::size_t stride = (rays.size() + 31) / 16 * 16;
    std::vector<float> words(10 * stride, 0.0F);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        words[k * stride + i] = rays[i].o[k];
        words[(3 + k) * stride + i] = rays[i].d[k];
      }
      words[6 * stride + i] = rays[i].t_max;
      words[7 * stride + i] = std::bit_cast<float>(rays[i].left);
      words[8 * stride + i] = std::bit_cast<float>(rays[i].goal);
      words[9 * stride + i] = rays[i].time;
    }
    arguments_.set("rays", device_.upload(words));
    const Buffer hits = device_.allocate(kHitWords * stride * sizeof(float));
    arguments_.set("hits", hits);
    arguments_.set("ray_count", static_cast<std::uint32_t>(rays.size()));
    arguments_.set("stride", static_cast<std::uint32_t>(stride));
    arguments_.set("coherent", coherent_ ? 1U : 0U);
    kernel.bind(arguments_);
    device_.run(kernel, (rays.size() + kChunk - 1) / kChunk, 1, rays.size());
    return device_.read_all<float>(hits);
  }

  Device& device_;
  Accel accel_;
  bool coherent_;
  bool two_level_ = false;
  Arguments arguments_;
  Kernel closest_, any_;
};

}  // namespace eikon
