// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Lamps and surfaces of the simulated cell: how much light a point sends to the eye.

#include "sim/raycaster.h"

#include <cstdint>
#include <string>
#include <vector>

namespace planar_bin_picking::cell {

/// How a surface looks: Lambert, a glossy lobe, a blurred mirror, and a pattern on it.
struct Material {
  float diffuse = 0.4f, gloss = 0.3f, mirror = 0.2f;
  float exponent = 30.0f;  ///< of the glossy lobe
  float grain = 0.08f;     ///< contrast of the pattern
  float stretch = 12.0f;   ///< how many times as long as wide its streaks are
};

/// @param name  rolled, brushed, painted, plastic
/// @throws std::invalid_argument  another name
Material material(const std::string& name);

/// Lamps as points that together cover them, and the light that comes from all around.
struct Lamps {
  struct Point {
    Eigen::Vector3f position, normal;
    float power;
    Eigen::Vector3f u, v;  ///< the piece of the lamp that it stands for
  };
  std::vector<Point> points;
  float ambient = 0.2f;
};

/// @param name  diffuse (a large panel overhead), ring (about the lens), side (a small panel, low)
/// @throws std::invalid_argument  another name
Lamps makeLamps(const std::string& name, const Eigen::Isometry3d& T_base_camera);

/// A point that is seen.
struct Spot {
  Eigen::Vector3f position, normal, view;  ///< view: unit, toward the eye
};

/// Light that arrives at a spot; its surface decides what becomes of it.
struct Arriving {
  float diffuse = 0.0f;  ///< irradiance
  float gloss = 0.0f;    ///< what a lobe of the material's exponent catches
  float mirror = 0.0f;   ///< from the mirrored direction
};

/// @param share  0..3: which quarter of the lamps' points and of the sky is looked at
Arriving gather(const Raycaster& world, const Lamps& lamps, const Spot& spot, float exponent,
                int share);

/// Factor about 1 of the pattern at a point of the part, for one instance of it.
float pattern(const Material& material, const Eigen::Vector3f& x_part, std::uint32_t seed);

}  // namespace planar_bin_picking::cell
