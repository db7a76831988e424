// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Plates that the tests of the stages look for, and what those stages need to know of them.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/part/part_model.h"
#include "sim/plate_image.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace planar_bin_picking {

inline constexpr double kDegrees = 3.14159265358979323846 / 180.0;  ///< one, in radians

inline sim::Ring circle(double x, double y, double radius, bool clockwise = false) {
  constexpr int kCorners = 180;
  sim::Ring ring;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = (clockwise ? -2.0 : 2.0) * kDegrees * i;
    ring.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle)});
  }
  return ring;
}

inline sim::Ring rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

/// An L of 80 x 50 mm with two holes: no symmetry, and its mirror image is another part. The origin
/// lies off the middle on purpose.
inline sim::Plate bracketPlate() {
  return {{{-33, -29}, {47, -29}, {47, -9}, {-3, -9}, {-3, 21}, {-33, 21}},
          {circle(-18, 6, 6, true), circle(32, -19, 4, true)},
          {},
          0.0};
}

/// 120 x 10 mm with a hole near one end: the turn about its long axis is held by little.
inline sim::Plate slenderPlate() {
  return {rectangle(-60, -5, 60, 5), {circle(-50, 0, 3, true)}, {}, 0.0};
}

/// A square with a hole in each corner, the same from all four sides and from behind, but for the
/// print.
inline sim::Plate printedPlate() {
  sim::Plate plate{rectangle(-30, -30, 30, 30), {}, {rectangle(-10, 2, 20, 14)}, 0.0};
  for (const double x : {-20.0, 20.0}) {
    for (const double y : {-20.0, 20.0}) plate.holes.push_back(circle(x, y, 4, true));
  }
  return plate;
}

/// Teeth of trapezoid shape; the bore has a keyway toward +y where wanted.
inline sim::Plate wheelPlate(int teeth, bool keyway) {
  sim::Plate plate;
  for (int i = 0; i < teeth; ++i) {
    const double pitch = 360.0 / teeth * kDegrees, middle = 90.0 * kDegrees + i * pitch;
    for (const auto& [share, radius] :
         {std::pair{-0.30, 31.0}, {-0.15, 36.0}, {0.15, 36.0}, {0.30, 31.0}}) {
      const double angle = middle + share * pitch;
      plate.outer.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
  }
  sim::Ring bore;
  for (const auto& p : circle(0, 0, 10, true)) {
    if (!keyway || p.y() < 0.0 || std::abs(p.x()) > 2.0) bore.push_back(p);
  }
  if (keyway) {  // clockwise, the bore reaches the keyway from its left
    const auto after = std::find_if(bore.begin(), bore.end(), [](const Eigen::Vector2d& p) {
      return p.y() > 0.0 && p.x() > 0.0 && p.x() < 2.5;
    });
    bore.insert(after, {{-2.0, 13.5}, {2.0, 13.5}});
  }
  plate.holes.push_back(bore);
  return plate;
}

inline std::shared_ptr<const PartModel> makePart(const std::string& name, const sim::Plate& plate) {
  PartFile file;
  file.name = name;
  file.thickness = 1e-3 * plate.thickness_mm;
  const auto add = [&file](LoopKind kind, const sim::Ring& ring) {
    Loop loop;
    loop.kind = kind;
    for (const auto& p : ring) loop.points.push_back(1e-3 * p);
    file.drawing.loops.push_back(loop);
  };
  add(LoopKind::kOuter, plate.outer);
  for (const auto& ring : plate.holes) add(LoopKind::kHole, ring);
  for (const auto& ring : plate.prints) add(LoopKind::kPrint, ring);
  return std::make_shared<const PartModel>(file);
}

/// @param lens  of a simulated camera, however its distortion is called
template <class Lens, class Distortion>
Camera makeCamera(const Lens& lens, const Distortion& distortion) {
  Camera::Model model;
  model.width = lens.width;
  model.height = lens.height;
  model.fx = lens.fx;
  model.fy = lens.fy;
  model.cx = lens.cx;
  model.cy = lens.cy;
  model.distortion.assign(distortion.begin(), distortion.end());
  return Camera(model);
}

inline Camera makeCamera(const sim::PinholeCamera& camera) {
  return makeCamera(camera, camera.lens);
}

/// A scene with one plate in it.
inline sim::Scene sceneOf(const sim::Plate& plate, const sim::Lie& lie) {
  sim::Scene scene;
  scene.plates.push_back({plate, sim::poseOf(lie)});
  return scene;
}

inline Face faceOf(const Eigen::Isometry3d& T_camera_part) {
  return T_camera_part.linear()(2, 2) < 0.0 ? Face::kFront : Face::kBack;
}

}  // namespace planar_bin_picking
