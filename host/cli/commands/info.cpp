// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/flags.h"
#include "job/prepare.h"
#include "pack/materials/camera_medium.h"
#include "pack/materials/material_traits.h"
#include "wavefront/layout/choose_layout.h"
#include "wavefront/memory_need.h"
#include "wavefront/photons/photon_map.h"
#include "pack/pack.h"
#include "pack/geometry/instanced_meshes.h"
#include "render/render.h"
#include "scene/emission.h"
#include "scene/measured_table.h"
#include "io/text.h"

namespace eikon {
namespace {

struct InfoOptions {
  SceneOptions scene;
  Execution execution;
};

/// "thin glass of index 1.5, roughness 0.2"
std::string describe_base(const Material& material) {
  if (material.unlit) return "unlit";
  if (material.measured) return "measured by " + material.measured->name;
  const bool metal = material.metallic == 1 && !material.metallic_roughness_texture;
  const bool transmits = material.transmission > 0 && !metal;
  const bool mirrorless = material.specular == 0 || material.ior == 1;
  const std::string other = transmits
                                ? fmt::format("{} of index {:g}", material.solid ? "glass" : "thin glass", material.ior)
                            : mirrorless ? "diffuse"
                                         : "dielectric";
  const std::string text = metal ? "metal" : material.metallic > 0 ? other + " and metal" : other;
  const bool is_rough = metal || transmits || !mirrorless || material.metallic > 0;
  return is_rough ? text + fmt::format(", roughness {:g}", material.roughness) : text;
}

std::string in_brackets(const glm::vec3& v) { return fmt::format("({:g}, {:g}, {:g})", v.x, v.y, v.z); }

/// The layers in and on the base: ", clearcoat 1 of roughness 0.1"; empty if there are none.
std::string describe_extensions(const Material& material) {
  std::string text;
  if (material.diffuse_transmission > 0)
    text += fmt::format(", diffuse transmission {:g} of colour {}", material.diffuse_transmission,
                        in_brackets(material.diffuse_transmission_color));
  if (material.dispersion > 0 && material.solid) text += fmt::format(", dispersion {:g}", material.dispersion);
  if (material.anisotropy > 0) text += fmt::format(", anisotropy {:g}", material.anisotropy);
  if (material.iridescence > 0)
    text +=
        fmt::format(", iridescence {:g} by a film of index {:g}, {:g} to {:g} nm", material.iridescence,
                    material.thin_film_index, material.thin_film_thickness_nm[0], material.thin_film_thickness_nm[1]);
  if (material.lobe == Lobe::phong)
    text += fmt::format(", highlights {} of shininess {:g}", in_brackets(material.phong_specular),
                        material.phong_shininess);
  if (material.lobe == Lobe::conductor)
    text += fmt::format(", conductor of eta {} and k {}", in_brackets(material.conductor_eta),
                        in_brackets(material.conductor_k));
  if (material.clearcoat > 0)
    text += fmt::format(", clearcoat {:g} of roughness {:g}", material.clearcoat, material.clearcoat_roughness);
  if (material.sheen_color != glm::vec3(0.0F))
    text += fmt::format(", sheen {} of roughness {:g}", in_brackets(material.sheen_color), material.sheen_roughness);
  return text;
}

/// "metal, roughness 0.2, masked at 0.5, textures: base color, normal"
std::string describe(const Material& material) {
  std::string text = describe_base(material);
  if (material.alpha_mode == AlphaMode::mask) text += fmt::format(", masked at {:g}", material.alpha_cutoff);
  if (material.alpha_mode == AlphaMode::blend) text += fmt::format(", blended with opacity {:g}", material.opacity);
  if (material.emission != glm::vec3(0.0F)) text += fmt::format(", emits {} W/(sr m2)", in_brackets(material.emission));
  if (material.double_sided) text += ", double-sided";
  text += describe_extensions(material);
  std::string textures;
  for (const TextureUse& use : textures_of(material)) textures += (textures.empty() ? ", textures: " : ", ") + use.name;
  return text + textures;
}

void print_materials(const Scene& scene) {
  const std::vector<bool> used = shown_materials(scene);
  fmt::print("materials\n");
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) fmt::print("  {}: {}\n", label("material", i, scene.materials[i].name), describe(scene.materials[i]));
  if (const auto unused = std::count(used.begin(), used.end(), false); unused > 0)
    fmt::print("  {}{} that nothing uses\n", unused == std::ssize(used) ? "" : "and ", unused);
  fmt::print("textures\n");
  const TextureImage* largest = nullptr;
  double bytes = 0;
  for (const TextureImage& image : scene.images) {
    bytes += double(image.rgba8.size() * sizeof(std::uint32_t));
    if (largest == nullptr || image.rgba8.size() > largest->rgba8.size()) largest = &image;
  }
  if (largest == nullptr)
    fmt::print("  none\n");
  else
    fmt::print("  {} images, {:.1f} MB decoded; the largest has {} x {} pixels: {}\n", scene.images.size(),
               bytes * 1e-6, largest->width, largest->height, largest->name);
}

/// Prints the size of measured materials, if there are any.
void print_tables(const Scene& scene) {
  std::set<const MeasuredTable*> tables;
  for (const Material& material : scene.materials)
    if (material.measured) tables.insert(material.measured.get());
  if (!tables.empty())
    fmt::print("measured tables\n  {} of {:.1f} MB each, as single precision, on the host and each device\n",
               tables.size(), 4e-6 * EK_MEASURED_WORDS);
}

/// The box around the scene. Far from the origin more digits tell its sides apart.
void print_bounds(const Bounds& box) {
  const double size = glm::length(box.hi - box.lo);
  const auto text = [&](double x) {
    const double more = x != 0 && size > 0 ? std::ceil(std::log10(std::abs(x) / size)) : 0;
    return fmt::format("{:.{}g}", x, int(std::clamp(4 + more, 6.0, 15.0)));
  };
  fmt::print("  bounds ({}, {}, {}) to ({}, {}, {}) m\n", text(box.lo.x), text(box.lo.y), text(box.lo.z),
             text(box.hi.x), text(box.hi.y), text(box.hi.z));
}

/// Prints how meshes with several instances are stored, if there are any.
void print_instances(const InstancedMeshes& instanced, const InstanceChoice& choice) {
  if (choice.flat_bytes == 0) return;
  fmt::print("  instances: {} ({}); two levels take about {:.1f} MB, one for each instance {:.1f} MB",
             choice.two_level ? "two levels" : "flattened", choice.why, double(choice.two_level_bytes) * 1e-6,
             double(choice.flat_bytes) * 1e-6);
  if (choice.two_level)
    fmt::print("; {} meshes of {} triangles in {} instances, {} triangles stored for each instance",
               instanced.meshes.size(), instanced.stored_triangles, instanced.instances.size(),
               instanced.other_triangles);
  fmt::print("\n");
}

/// Prints how much larger compressed meshes become, if there are any.
void print_compression(const CompressedMeshes& meshes) {
  if (meshes.file_bytes == 0) return;
  fmt::print("  compressed meshes: {:.1f} MB in the file, {:.1f} MB unpacked{}\n", double(meshes.file_bytes) * 1e-6,
             double(meshes.unpacked_bytes) * 1e-6,
             meshes.decoder_bytes == 0
                 ? ""
                 : fmt::format("; Draco's decoder takes {:.1f} MB at most", double(meshes.decoder_bytes) * 1e-6));
}

/// Prints "  shapes: 3 sphere, 1 box", if there are any.
void print_shapes(const Scene& scene) {
  std::string text;
  for (const ShapeKindInfo& kind : shape_kinds()) {
    const auto count = std::ranges::count(scene.shapes, kind.kind, &Shape::kind);
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, kind.name);
  }
  if (!text.empty()) fmt::print("  shapes: {}\n", text);
}

/// Prints a line per light. Units are radiometric, or photometric where the file means them so.
void print_lights(const PackedScene& packed) {
  fmt::print("lights (means of R, G and B; W stands for lm if the file means photometric units)\n");
  for (const PackedLight& light : packed.light_summary) {
    const LightKindInfo& kind = light_kind(light.kind);
    fmt::print("  {:<15} {}{:.6g} W (lm), {} {:.6g} {}{}, chosen with probability {:.4f}\n", kind.name,
               light.name.empty() ? "" : fmt::format("'{}': ", printable(light.name)), light.flux, kind.strength, light.strength,
               kind.unit, light.area_m2 > 0 ? fmt::format(", area {:.6g} m^2", light.area_m2) : "", light.probability);
  }
  if (packed.light_summary.empty()) fmt::print("  none\n");
}

/// Names lights without extent inside a solid. Only shadow rays find them, and those end at a
/// refracting surface.
void print_enclosed_lights(const Scene& scene, const PackedScene& packed) {
  for (const PunctualLight& light : scene.lights) {
    if (light_kind(light.kind).distant) continue;
    const std::uint32_t solid = solid_around(scene, packed, light.position, light.direction);
    if (solid != 0)
      fmt::print(
          "  light {} stands in the solid {}: a point lights what is in there with it, and beyond a smooth surface "
          "nothing\n",
          in_quotes(light.name), in_quotes(scene.materials[solid - 1].name));
  }
}

/// Names surfaces that emit without being in the list of lights.
void print_unsampled_emitters(const Scene& scene) {
  for (const Shape& shape : scene.shapes) {
    const Material& material = scene.materials[shape.material];
    if (!emits(material) || is_sampled_light(shape, material)) continue;
    fmt::print("  surface {} {} emits, but is no light to sample: scattered rays alone find it\n",
               in_quotes(shape.name), shape.kind == ShapeKind::implicit ? "by formula" : "without end");
  }
}

/// A scene as info looks at it: the triangles of its file, and counts of what a render makes of
/// them.
struct Contents {
  Prepared prepared;
  InstanceChoice instances;
  Features features;
  InstancedMeshes instanced;
  LightOverview light;

  [[nodiscard]] std::uint64_t packed_triangles() const { return instanced.packed_triangles(instances.two_level); }
};

void print_contents(const Contents& contents) {
  const Prepared& prepared = contents.prepared;
  const PackedScene& packed = contents.light.packed;
  const Scene& scene = *prepared.scene;
  fmt::print("{}: {} bytes, hash {}\n", printable(scene.path.string()), scene.file_bytes, scene.hash);
  fmt::print("  {} triangles in {} nodes, {} meshes, {} materials, {} cameras\n",
             contents.instanced.packed_triangles(false), scene.nodes.size(), scene.meshes.size(),
             scene.materials.size(), scene.cameras.size());
  print_instances(contents.instanced, contents.instances);
  print_compression(scene.compressed);
  print_shapes(scene);
  if (!packed.bounds.empty()) print_bounds(packed.bounds);
  fmt::print("  image {} x {}, camera '{}'\n", prepared.settings.width, prepared.settings.height, prepared.camera_name);
  if (scene.cameras.size() > 1) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) names.push_back(label("camera", i, scene.cameras[i].name));
    fmt::print("cameras (--camera NAME|INDEX)\n  {}\n", fmt::join(names, ", "));
  }
  if (!scene.variants.empty()) {
    std::vector<std::string> names;
    for (const std::string& name : scene.variants) names.push_back(in_quotes(name));
    fmt::print("variants (--variant NAME)\n  {}\n", fmt::join(names, ", "));
  }
}

/// Prints what can move, if anything can.
void print_motion(const Scene& scene) {
  if (!scene.animations.empty())
    fmt::print(
        "animations (--animation NAME, --scene-time SECONDS; frames are of 1/24 s unless --fps says otherwise)\n");
  for (std::size_t i = 0; i < scene.animations.size(); ++i) {
    const AnimationSummary& animation = scene.animations[i];
    const std::string name = label("animation", i, animation.name);
    if (animation.channel_count == 0)
      fmt::print("  {}: moves nothing\n", name);
    else
      fmt::print("  {}: {:g} to {:g} s, {} channels{}\n", name, animation.begin_s, animation.end_s,
                 animation.channel_count, animation.in_force ? "" : ", not in force");
  }
  if (!scene.skins.empty()) fmt::print("skins\n");
  for (std::size_t i = 0; i < scene.skins.size(); ++i)
    fmt::print("  {}: {} joints\n", label("skin", i, scene.skins[i].name), scene.skins[i].joint_count);
  if (!scene.morphs.empty()) fmt::print("morph targets\n");
  for (const MorphSummary& morph : scene.morphs) {
    std::vector<std::string> names;
    for (const std::string& name : morph.names) names.push_back(in_quotes(name));
    fmt::print("  {}: {}{}{}\n", label("mesh", morph.mesh_index, morph.mesh), morph.target_count,
               names.empty() ? "" : ": ", fmt::join(names, ", "));
  }
}

/// Bytes of the scene without its tree.
std::uint64_t record_bytes(const Contents& contents) {
  return contents.light.bytes + contents.packed_triangles() * triangle_bytes(contents.features);
}
/// Bytes of the tree in a layout. They are estimated, because to build it takes more memory than
/// all the rest of info.
std::uint64_t tree_bytes(const Contents& contents, const std::string& layout) {
  const std::uint64_t leaves = contents.packed_triangles() + contents.light.packed.shapes.size();
  return expected_tree_bytes(layout, leaves) +
         (contents.instances.two_level ? contents.instanced.instances.size() * sizeof(InstanceRecord) : 0);
}

/// Prints what scene and tree take in each layout.
void print_scene_memory(const Contents& contents) {
  const std::uint64_t shapes = contents.light.packed.shapes.size(), records = record_bytes(contents);
  for (const std::string& layout : tree_layouts()) {
    if (contents.instances.two_level && !has_two_levels(layout)) continue;
    const std::uint64_t tree = tree_bytes(contents, layout);
    const std::uint64_t seen = contents.instanced.packed_triangles(false) + shapes;
    fmt::print("  {}: tree about {} bytes, scene about {} bytes{}\n", layout, tree, records + tree,
               seen == 0 ? "" : fmt::format(" ({:.0f} per triangle)", double(records + tree) / double(seen)));
  }
}

void print_device_memory(const Contents& contents, Execution execution) {
  const Features& features = contents.features;
  const std::uint64_t triangles = contents.packed_triangles() + contents.light.packed.shapes.size();
  const double rays = expected_rays(contents.prepared.settings);
  read_execution_environment(execution);
  for (const DeviceInfo& info : list_devices()) {
    const Settings& settings = contents.prepared.settings;
    const LayoutPlan plan =
        plan_layout(configure(info, execution), execution, triangles, rays, features.has(Feature::instance));
    const std::uint64_t photons = features.has(Feature::merging) ? photon_map_bytes(settings) : 0;
    const std::uint64_t scene = record_bytes(contents) + tree_bytes(contents, plan.layout) + photons;
    const WavefrontConfig config =
        configure(info, fit_units(info, features, settings, execution, {.beside_bytes = scene}));
    fmt::print("  device {}: {} bytes for {} paths in flight, beside the scene as {} ({}{})\n", info.index,
               unit_buffer_bytes(config, features, settings).total, config.capacity(), plan.layout, plan.why,
               plan.measure.empty() ? "" : fmt::format("; a render measures {} first", fmt::join(plan.measure, ", ")));
  }
}

Contents look_at(const InfoOptions& options) {
  Prepared prepared = prepare(options.scene, log_unless(false), MissingTangents::mark);
  const Scene& scene = *prepared.scene;
  InstanceChoice instances;
  Features features = features_of(scene, prepared.settings, options.execution, &instances);
  LightOverview light = look_at_light(scene, features, prepared.settings);
  InstancedMeshes instanced = find_instanced_meshes(scene);
  return {.prepared = std::move(prepared),
          .instances = std::move(instances),
          .features = std::move(features),
          .instanced = std::move(instanced),
          .light = std::move(light)};
}

ExitCode info_command(const InfoOptions& options) {
  const Contents contents = look_at(options);
  const Scene& scene = *contents.prepared.scene;
  print_contents(contents);
  print_motion(scene);
  print_materials(scene);
  print_tables(scene);
  print_lights(contents.light.packed);
  print_enclosed_lights(scene, contents.light.packed);
  print_unsampled_emitters(scene);
  fmt::print("features\n");
  for (const FeatureEntry& feature : contents.features.entries())
    fmt::print("  {:<7} {:<16} {:<3}  {}\n", feature.kind, feature.name, feature.on ? "in" : "out", printable(feature.reason));
  fmt::print("memory, of each device and of the host\n");
  print_scene_memory(contents);
  print_device_memory(contents, options.execution);
  if (scene.moves_surfaces)
    fmt::print("  what moves while the shutter is open: {} bytes more, in {} poses, and its tree as much again\n",
               pose_bytes(scene, contents.features), scene.poses.size());
  fmt::print("  film: {} bytes\n", film_bytes(film_layout(contents.features, contents.prepared.settings)));
  return ExitCode::done;
}

}  // namespace

void add_info(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<InfoOptions>();
  CommandFlags flags = root.command("info", "show what a scene contains, which features it needs, and how much memory",
                                    "Example:\n  eikon info scenes/cornell.gltf");
  add_all_scene_flags(flags, options->scene);
  add_shutter_flags(flags, options->scene.animation);
  flags.hide({"--seed"});
  flags.group("Devices");
  add_instance_flag(flags, options->execution);
  flags.run(chosen, [options] { return info_command(*options); });
}

}  // namespace eikon
