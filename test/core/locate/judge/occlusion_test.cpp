// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/occlusion.h"

#include "support/stages.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{10, -5, 600, 20, 6};

/// A plain plate of 80 x 50 mm: 40 x 25 cells.
sim::Plate plainPlate() {
  sim::Plate plate;
  plate.outer = rectangle(-40, -25, 40, 25);
  return plate;
}

/// Outline pieces every 0.5 mm; those for which `missing` holds are not seen.
template <class Missing>
std::vector<OutlinePiece> outlineOf(Missing&& missing) {
  std::vector<OutlinePiece> pieces;
  const auto add = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const Eigen::Vector2d d = to - from, t = d.normalized();
    for (double s = 0.25; s < d.norm(); s += 0.5) {
      const Eigen::Vector2d p = from + s * t;
      pieces.push_back({1e-3 * p, {t.y(), -t.x()}, 0.5e-3, !missing(p)});
    }
  };
  add({-40, -25}, {40, -25});
  add({40, -25}, {40, 25});
  add({40, 25}, {-40, 25});
  add({-40, 25}, {-40, -25});
  return pieces;
}

std::vector<int> coveredOf(const FaceGrid& grid, const Shot& shot, const Eigen::Isometry3d& T,
                           const std::vector<OutlinePiece>& outline) {
  return findOcclusion(grid, flatten(grid, shot.edges.image, shot.camera, T, 0.0), outline);
}

struct Counts {
  int inside = 0, outside = 0;
};

/// Covered cells inside and outside of the box x0..x1, y0..y1 (mm, part frame), the plate's grey
/// there being `grey` in the picture.
template <class Missing>
Counts occlusionOf(double x0, double x1, double y0, double y1, double grey, Missing&& missing) {
  const auto part = makePart("plain", plainPlate());
  sim::Scene scene = sceneOf(plainPlate(), kLie);
  if (grey > 0.0)
    scene.plates.push_back({{rectangle(x0, y0, x1, y1), {}, {}, 0.0}, sim::poseOf(kLie), grey});
  const Shot shot = shoot(scene);
  const FaceGrid& grid = part->faceGrid();
  Counts counts;
  for (const int i : coveredOf(grid, shot, sim::poseOf(kLie), outlineOf(missing))) {
    const Eigen::Vector2d p = 1e3 * grid.cells()[i];
    const bool is_inside = p.x() > x0 - 1 && p.x() < x1 + 1 && p.y() > y0 - 1 && p.y() < y1 + 1;
    ++(is_inside ? counts.inside : counts.outside);
  }
  return counts;
}

TEST(Occlusion, AFreeFaceHasNone) {
  const Counts none = occlusionOf(0, 0, 0, 0, 0.0, [](const auto&) { return false; });
  EXPECT_EQ(none.inside + none.outside, 0);
}

TEST(Occlusion, AStripAcross) {
  for (const double grey : {90.0, 230.0}) {
    const Counts counts =
        occlusionOf(-10, 6, -40, 40, grey, [](const auto& p) { return p.x() > -10 && p.x() < 6; });
    EXPECT_GT(counts.inside, 0.9 * 200) << grey;
    EXPECT_LT(counts.outside, 30) << grey;
  }
}

TEST(Occlusion, EndsWhereTheBrightnessChanges) {
  // Strips along whole cells of 2 mm, off the middle; the outline is missing at their ends only.
  for (const double grey : {90.0, 230.0}) {
    const Counts upright =
        occlusionOf(4, 16, -40, 40, grey, [](const auto& p) { return p.x() > 4 && p.x() < 16; });
    EXPECT_EQ(upright.inside, 6 * 25) << grey;
    EXPECT_EQ(upright.outside, 0) << grey;
    const Counts level =
        occlusionOf(-60, 60, -9, 5, grey, [](const auto& p) { return p.y() > -9 && p.y() < 5; });
    EXPECT_EQ(level.inside, 40 * 7) << grey;
    EXPECT_EQ(level.outside, 0) << grey;
  }
}

TEST(Occlusion, EndsWhereverInACellTheBrightnessChanges) {
  // The cells are 2 mm wide, their middles at odd millimetres: those under the strip are covered.
  for (const double from : {3.5, 4.5, 3.4, 4.4}) {
    const double to = from + 12.0;
    const Counts upright = occlusionOf(from, to, -40, 40, 90.0,
                                       [&](const auto& p) { return p.x() > from && p.x() < to; });
    EXPECT_EQ(upright.inside, 6 * 25) << from;
    EXPECT_EQ(upright.outside, 0) << from;
    const double low = from - 13.0, high = low + 14.0;  // a row's middle is at an even millimetre
    const Counts level = occlusionOf(-60, 60, low, high, 90.0,
                                     [&](const auto& p) { return p.y() > low && p.y() < high; });
    EXPECT_EQ(level.inside, 40 * 7) << low;
    EXPECT_EQ(level.outside, 0) << low;
  }
}

TEST(Occlusion, AMissingCornerIsTheCellInIt) {
  for (const double x : {-40.0, 40.0}) {
    for (const double y : {-25.0, 25.0}) {
      const auto missing = [&](const Eigen::Vector2d& p) {
        return std::abs(p.x() - x) < 2.0 && std::abs(p.y() - y) < 2.0;
      };
      // One cell's middle is within a millimetre of this box.
      const Counts counts = occlusionOf(x - 0.5, x + 0.5, y - 0.5, y + 0.5, 0.0, missing);
      EXPECT_EQ(counts.inside, 1) << x << " " << y;
      EXPECT_EQ(counts.outside, 0) << x << " " << y;
    }
  }
}

/// How many of the outermost cells at one of the image's borders are covered: `axis` 0 for the left
/// (outward -1) and the right one, 1 for the upper and the lower one. Their middles lie `beyond`
/// pixels out of the image. `inside`: these; `outside`: all others that are covered, too.
Counts coveredAtBorder(int axis, double outward, double beyond) {
  static const auto part = makePart("plain", plainPlate());
  const FaceGrid& grid = part->faceGrid();
  const Camera camera = makeCamera(kPinhole);
  Eigen::Vector2d corner(0.0, 0.0);  // the last cell's middle
  for (const auto& p : grid.cells()) corner = corner.cwiseMax(p);
  Eigen::Vector2d pixel(0.5 * kPinhole.width, 0.5 * kPinhole.height);
  const double last = (axis == 0 ? kPinhole.width : kPinhole.height) - 1.0;
  pixel(axis) = (outward > 0.0 ? last : 0.0) + outward * beyond;
  Eigen::Vector3d middle = 0.6 * camera.undistort(pixel).homogeneous();
  middle(axis) -= outward * corner(axis);
  const Eigen::Isometry3d T = sim::poseOf({1e3 * middle.x(), 1e3 * middle.y(), 600.0, 0.0, 0.0});
  sim::Scene scene;
  scene.plates.push_back({plainPlate(), T});
  const Shot shot = shoot(scene);
  Counts counts;
  for (const int i : coveredOf(grid, shot, T, outlineOf([](const auto&) { return false; }))) {
    const Eigen::Vector3d at = T * Eigen::Vector3d(grid.cells()[i].x(), grid.cells()[i].y(), 0.0);
    const bool is_last = std::abs(at(axis) - middle(axis) - outward * corner(axis)) < 1e-6;
    ++(is_last ? counts.inside : counts.outside);
  }
  return counts;
}

TEST(Occlusion, TheImageEndsAtItsLastPixels) {
  for (const double outward : {-1.0, 1.0}) {
    for (const int axis : {0, 1}) {  // of 40 x 25 cells
      const Counts within = coveredAtBorder(axis, outward, -0.6);
      const Counts beyond = coveredAtBorder(axis, outward, 0.6);
      EXPECT_EQ(within.inside + within.outside, 0) << axis << " " << outward;
      EXPECT_EQ(beyond.inside, axis == 0 ? 25 : 40) << axis << " " << outward;
      EXPECT_EQ(beyond.outside, 0) << axis << " " << outward;
    }
  }
}

TEST(Occlusion, ACornerHidden) {
  const Counts counts =
      occlusionOf(20, 60, 5, 60, 100.0, [](const auto& p) { return p.x() > 20 && p.y() > 5; });
  EXPECT_GT(counts.inside, 0.9 * 100);
  EXPECT_LT(counts.outside, 20);
}

TEST(Occlusion, AFaintSectionAloneIsNone) {
  // As long as the strip's ends, and nothing runs across the face.
  const Counts counts = occlusionOf(
      -10, 6, -25, -20, 0.0, [](const auto& p) { return p.x() > -10 && p.x() < 6 && p.y() < 0; });
  EXPECT_LE(counts.inside, 10);  // the cells along it at most
  EXPECT_EQ(counts.outside, 0);
}

TEST(Occlusion, AMarkOnTheFaceIsNone) {
  const Counts counts = occlusionOf(-10, 6, -8, 8, 90.0, [](const auto&) { return false; });
  EXPECT_EQ(counts.inside + counts.outside, 0);
}

TEST(Occlusion, TextureLooksLikeSomeOfACoveredSection) {
  const auto hides = [](const Eigen::Vector2d& p) { return p.x() > -10 && p.x() < 6; };
  const Counts counts = occlusionOf(-10, 6, -40, 40, 100.0, [&](const auto& p) {
    return hides(p) && static_cast<int>(std::floor(2.0 * p.x())) % 5 < 3;  // two of five are "seen"
  });
  EXPECT_GT(counts.inside, 0.9 * 200);
}

TEST(Occlusion, WhatTheImageDoesNotShowCountsAsCovered) {
  const auto part = makePart("plain", plainPlate());
  const std::vector<Eigen::Vector2d>& cells = part->faceGrid().cells();
  for (const double side : {-1.0, 1.0}) {
    for (const bool upright : {false, true}) {
      sim::Lie lie = kLie;  // its middle on the image's border
      (upright ? lie.y_mm : lie.x_mm) =
          side * 600.0 * 0.5 * (upright ? kPinhole.height : kPinhole.width) / kPinhole.fx;
      const Shot shot = shoot(sceneOf(plainPlate(), lie));
      const auto covered = coveredOf(part->faceGrid(), shot, sim::poseOf(lie),
                                     outlineOf([](const auto&) { return false; }));
      std::vector<int> outside;
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const Eigen::Vector2d p =
            shot.camera.project(sim::poseOf(lie) * Eigen::Vector3d(cells[i].x(), cells[i].y(), 0));
        if (p.x() < 0 || p.y() < 0 || p.x() > kPinhole.width - 1 || p.y() > kPinhole.height - 1)
          outside.push_back(static_cast<int>(i));
      }
      EXPECT_GT(outside.size(), cells.size() / 4);
      EXPECT_TRUE(std::includes(covered.begin(), covered.end(), outside.begin(), outside.end()));
      EXPECT_LT(covered.size(), cells.size()) << side << " " << upright;
    }
  }
}

}  // namespace
}  // namespace planar_bin_picking
