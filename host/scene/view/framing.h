// SPDX-License-Identifier: Apache-2.0
// A camera in front of one or more poses of a scene, all of which it shows.
#pragma once
#include <algorithm>
#include <glm/glm.hpp>
#include <optional>

#include "scene/scene.h"

namespace eikon {

/// Collects what has to fit into the picture of frame_camera.
class Framing {
 public:
  explicit Framing(double aspect);
  /// Adds what shows of a scene.
  void add(const Scene& scene);
  [[nodiscard]] Camera camera() const;

 private:
  /// The range of positions of a camera along one axis of its picture and along its axis of view.
  /// [Every point p satisfies |p.side - at.side| <= tangent * (at.back - p.back) if and only if
  /// `most` <= at.side + tangent * at.back and `least` <= tangent * at.back - at.side.]
  struct Fit {
    double tangent;
    double most = -1e300, least = -1e300;
    void add(double side, double back) {
      most = std::max(most, side + tangent * back);
      least = std::max(least, tangent * back - side);
    }
    [[nodiscard]] double side() const { return 0.5 * (most - least); }
    [[nodiscard]] double back() const { return 0.5 * (most + least) / tangent; }
  };

  void add_point(const glm::dvec3& p);

  double aspect_;  // 0: none is asked for
  glm::dvec3 back_{}, right_{}, up_{};
  Fit across_{}, along_{};
  Bounds bounds_;
  std::optional<glm::dvec3> center_;  // positions are counted from here: the middle of the first scene
  bool shows_ = false;
};

}  // namespace eikon
