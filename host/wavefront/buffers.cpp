// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "core/error.h"
#include "pack/frame.h"
#include "pack/lights/pack_light_paths.h"
#include "shared/guide.h"
#include "shared/queue_counts.h"
#include "shared/records.h"
#include "wavefront/buffers.h"
#include "wavefront/tallies.h"

namespace eikon {

WorkBufferSizes work_buffer_sizes(const WavefrontConfig& config, const Features& features, const Settings& settings) {
  return {.film = {.replicates = 1U << settings.replicate_bits,
                   .channels = std::uint32_t(features.film_channels().size()),
                   .mattes = std::uint32_t(features.mattes().ids.size())},
          .state_words = path_state_layout(features, config.chunked).words,
          .hit_queues = hit_queue_count(config, features),
          .logs = features.has(Feature::path_log)};
}

WorkBytes work_bytes(const WavefrontConfig& config, const WorkBufferSizes& plan) {
  const FilmShape& film = plan.film;
  const std::size_t places = std::size_t{config.chunk + EK_PAD} * config.held_chunks();
  const std::size_t capacity = config.capacity(), pixel_capacity = config.pixels;
  return {.frame = sizeof(Frame),
          .pixels = 4 * pixel_capacity,
          .state = 4 * places * plan.state_words,
          .counts = config.chunked ? 4 * kQueueWords * config.chunks : 4 * std::size_t{EK_COUNT_WORDS},
          .film_slots = 4 * std::size_t{film.channels + film.mattes} * (capacity + EK_PAD) + 4 * EK_PAD,
          .diagnostics = sizeof(Diagnostics),
          .next_path = 4,
          .tallies = config.workers * sizeof(WorkerTally),
          .queue_rays = config.chunked ? 4 : 8 * capacity,
          .queue_hits = 4 * std::max<std::size_t>(capacity * plan.hit_queues, 1),
          .queue_shadow = config.chunked ? 4 : 4 * capacity,
          .path_log = plan.logs ? 4 * std::size_t{EK_LOG_DEPTHS} * LOG_WORDS * (capacity + EK_PAD) : 0,
          .sums = 4 * film.sum_words(pixel_capacity),
          .rejected = 4 * film.rejected_words(pixel_capacity),
          .packed = config.chunked ? 0 : 4 * film.packed_words(pixel_capacity),
          .sum_buffers = config.sum_buffers};
}

std::uint64_t WorkBytes::total() const {
  return frame + pixels + state + counts + film_slots + diagnostics + next_path + tallies + queue_rays + queue_hits +
         queue_shadow + path_log + sum_buffers * (sums + rejected + packed);
}

std::uint64_t WorkBytes::largest() const {
  return std::max({frame, pixels, state, counts, film_slots, diagnostics, next_path, tallies, queue_rays, queue_hits,
                   queue_shadow, path_log, sums, rejected, packed});
}

WorkBuffers::WorkBuffers(Device& device, const WavefrontConfig& config, const WorkBufferSizes& plan,
                         Arguments& arguments) {
  const auto allocate = [&](std::size_t size) {
    bytes += size;
    return device.allocate(size);
  };
  const WorkBytes sizes = work_bytes(config, plan);
  frame = allocate(sizes.frame);
  pixels = allocate(sizes.pixels);
  state = allocate(sizes.state);
  counts = allocate(sizes.counts);
  film_slots = allocate(sizes.film_slots);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const bool shares = i >= sizes.sum_buffers;
    sums[i] = shares ? sums[0] : allocate(sizes.sums);
    rejected[i] = shares ? rejected[0] : allocate(sizes.rejected);
    if (sizes.packed > 0) packed[i] = shares ? packed[0] : allocate(sizes.packed);
  }
  diagnostics = allocate(sizes.diagnostics);
  next_path = allocate(sizes.next_path);
  if (sizes.path_log > 0) {
    path_log = allocate(sizes.path_log);
    arguments.set("path_log", path_log);
  }
  tallies = allocate(sizes.tallies);
  // Lanes without a path read these before they are written. Zeros are valid indices.
  for (const Buffer& read_early : {state, film_slots, counts, diagnostics, next_path}) device.fill_zero(read_early);
  arguments.set("frame", frame);
  arguments.set("pixels", pixels);
  arguments.set("path_state", state);
  arguments.set("counts", counts);
  arguments.set("film_slots", film_slots);
  arguments.set("diagnostics", diagnostics);
  arguments.set("next_path", next_path);
  arguments.set("tallies", tallies);
  arguments.set("queue_rays", allocate(sizes.queue_rays));
  arguments.set("queue_hits", allocate(sizes.queue_hits));
  arguments.set("queue_shadow", allocate(sizes.queue_shadow));
}

namespace {

class Uploader {
 public:
  Uploader(Device& device, Arguments& arguments) : device_(device), arguments_(arguments) {}
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  template <class Array>
  void share(const char* name, const Array& values) {
    // An argument needs a buffer even if it is empty. Then it is one record of zeros, which is
    // never read.
    static const Array nothing(1);
    const Array& source = values.empty() ? nothing : values;
    const std::size_t size = source.size() * sizeof(source[0]);
    bytes_ += size;
    arguments_.set(name, device_.share(source.data(), size));
  }
  void fill_zero(const char* name, std::size_t size) {
    const Buffer zeros = device_.allocate(size);
    device_.fill_zero(zeros);
    bytes_ += size;
    arguments_.set(name, zeros);
  }
  void copy_texels(const PackedScene& scene) {
    const std::size_t size = 4 * std::max<std::size_t>(scene.texel_count(), 1);
    const Buffer texels = device_.allocate(size);
    bytes_ += size;
    std::size_t offset = 0;
    for (const std::span<const std::uint32_t> part : scene.texels) {
      device_.write(texels, part.data(), part.size_bytes(), offset);
      offset += part.size_bytes();
    }
    arguments_.set("texels", texels);
  }

 private:
  Device& device_;
  Arguments& arguments_;
  std::uint64_t bytes_ = 0;
};

void share_tree_and_lights(Uploader& to, const PackedScene& scene, const Accel& accel) {
  to.share("accel_nodes", accel.nodes);
  to.share("accel_leaves", accel.leaves);
  to.share("triangles", scene.triangles);
  to.share("instances", accel.instances);
  to.share("shapes", scene.shapes);
  to.share("motion", scene.motion);
  to.share("motion_nodes", accel.motion_nodes);
  to.share("motion_leaves", accel.motion_leaves);
  to.share("pose_triangles", scene.pose_triangles);
  to.share("light_poses", scene.light_poses);
  to.share("lights", scene.lights);
  to.share("light_alias_table", scene.light_alias_table);
  to.share("light_nodes", scene.light_nodes);
  to.share("emission_alias_table", scene.emission_alias_table);
  to.share("emission_pdf", scene.emission_pdf);
  to.share("emission_aim", scene.emission_aim);
  to.share("light_targets", scene.light_targets);
  to.share("light_aim", std::vector<std::uint32_t>{});  // nothing was learned
  to.share("environment_texels", scene.environment_texels);
  to.share("environment_alias_table", scene.environment_alias_table);
}

/// Two features read them.
void share_cameras(Uploader& to, const std::vector<float>& words) {
  to.share("camera_poses", words);
  to.share("motion_cameras", words);
}

}  // namespace

void upload_tree_and_lights(Device& device, const PackedScene& scene, const Accel& accel, Arguments& arguments) {
  Uploader to(device, arguments);
  share_tree_and_lights(to, scene, accel);
}

std::uint64_t upload_scene(Device& device, const PackedScene& scene, const Accel& accel,
                           const std::vector<float>& filter, const std::vector<float>& camera_poses,
                           Arguments& arguments) {
  Uploader to(device, arguments);
  share_tree_and_lights(to, scene, accel);
  to.share("triangle_normals", scene.normals);
  to.share("triangle_tangents", scene.tangents);
  to.share("triangle_colors", scene.colors);
  to.share("pose_normals", scene.pose_normals);
  to.share("pose_tangents", scene.pose_tangents);
  to.share("materials", scene.materials);
  to.share("material_extensions", scene.material_extensions);
  // Kernels read the lobe's detail of every material, and drop it where no material needs details.
  if (scene.material_details.empty())
    to.fill_zero("material_details", sizeof(MaterialDetail) * std::max<std::size_t>(scene.materials.size(), 1));
  else
    to.share("material_details", scene.material_details);
  to.share("textures", scene.textures);
  to.share("filter_table", filter);
  to.share("next_corners", scene.next_corners);
  share_cameras(to, camera_poses);
  return to.bytes();
}

std::uint64_t upload_texels(Device& device, const PackedScene& scene, Arguments& arguments) {
  Uploader to(device, arguments);
  to.copy_texels(scene);
  return to.bytes();
}

bool have_same_texels(const PackedScene& a, const PackedScene& b) {
  const auto same = [](std::span<const std::uint32_t> x, std::span<const std::uint32_t> y) {
    return x.data() == y.data() && x.size() == y.size();
  };
  return std::ranges::equal(a.texels, b.texels, same);
}

bool replace_camera(Device& device, const PackedScene& scene, const Settings& settings, std::vector<float>& poses,
                    Arguments& arguments) {
  std::vector<float> words = camera_pose_words(scene, settings);
  if (words == poses) return false;
  device.finish();
  poses = std::move(words);
  Uploader to(device, arguments);
  share_cameras(to, poses);
  return true;
}

void upload_light_aim(Device& device, const PackedScene& scene, LightAimBuffers& buffers, Arguments& arguments) {
  Uploader to(device, arguments);
  if (buffers.aim == nullptr || scene.light_targets.empty()) {
    to.share("light_aim", std::vector<std::uint32_t>{});
    to.share("emission_aim", scene.emission_aim);
    return;
  }
  if (buffers.aim->is_learned() && buffers.aim->target_count() != scene.light_targets.size())
    throw InternalError("the aim of light paths is of a scene with other targets");
  const auto [of_cones, of_discs] = buffers.aim->density_factor;
  buffers.emission_aim = scene.emission_aim;
  for (float& density : buffers.emission_aim) density = aim_within_bounds(density * of_cones);
  buffers.emission_aim.front() = scene.emission_aim.front() * of_discs;
  to.share("light_aim", buffers.aim->words);
  to.share("emission_aim", buffers.emission_aim);
}

void upload_guide(Device& device, const GuideTable& guide, Arguments& arguments) {
  Uploader to(device, arguments);
  to.share("guide_slots", guide.slots);
  to.share("guide_cells", guide.cells);
}

}  // namespace eikon
