// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/shape.h"

#include "sim/solid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking::cell {
namespace {

const std::string kParts = std::string(PACKAGE_DIR) + "/test/data/parts/";
constexpr double kPi = 3.14159265358979323846;

Shape load(const std::string& name, double thickness_mm, double chord = 1e-5) {
  return loadShape(kParts + name + ".dxf", 1e-3 * thickness_mm, chord);
}

TEST(LoadShape, HasTheDrawingsAreas) {
  // By hand: 70 x 70 less a corner of 18 x 18 / 2, three corners of radius 2, a pocket of 36 x 26
  // with corners of radius 5, two holes.
  const double corner = 1.0 - kPi / 4.0;
  const double expected_mm2 = 4900.0 - 162.0 - 3 * 4.0 * corner - (936.0 - 4 * 25.0 * corner) -
                              kPi * (5.5 * 5.5 + 4.0 * 4.0);
  EXPECT_NEAR(1e6 * area(load("block", 20.0, 1e-6)), expected_mm2, 0.1);
}

TEST(LoadShape, TurnsRingsTheRightWayRound) {
  for (const char* name : {"block", "bracket", "hinge", "linkarm", "sprocket"}) {
    const Shape shape = load(name, 5.0);
    EXPECT_GT(area(shape.outer), 0.0) << name;
    for (const Polygon& hole : shape.holes) {
      EXPECT_LT(area(hole), 0.0) << name;
      EXPECT_TRUE(contains({shape.outer, {}, 0.0}, hole[0])) << name;
      EXPECT_FALSE(contains(shape, 0.5 * (hole[0] + hole[hole.size() / 2]))) << name;
    }
  }
}

TEST(LoadShape, RefusesWhatItDoesNotRead) {
  EXPECT_THROW(load("nonesuch", 1.0), std::runtime_error);
  EXPECT_THROW(
      loadShape(std::string(PACKAGE_DIR) + "/test/data/bin_bracket_00/truth.yaml", 1e-3, 1e-5),
      std::exception);
}

TEST(Symmetries, AreTheDrawings) {
  EXPECT_EQ(symmetries(load("bracket", 3.0, 5e-5), 2e-4).size(), 1u);
  EXPECT_EQ(symmetries(load("hinge", 2.0, 5e-5), 2e-4).size(), 2u);    // upside down
  EXPECT_EQ(symmetries(load("linkarm", 6.0, 5e-5), 2e-4).size(), 2u);  // upside down
  EXPECT_EQ(symmetries(load("sprocket", 5.0, 5e-5), 2e-4).size(),
            2u);  // the keyway tells its teeth
}

TEST(Symmetries, LayTheBodyOnItself) {
  const Shape shape = load("hinge", 2.0);
  const Eigen::Isometry3d flip = symmetries(shape, 2e-4).at(1);
  const Eigen::Vector3d corner = flip * Eigen::Vector3d(0.022, 0.046, 0.0);
  EXPECT_NEAR((corner - Eigen::Vector3d(0.078, 0.046, -0.002)).norm(), 0.0, 1e-6);
}

TEST(MakeMesh, IsClosedAndHasTheVolume) {
  const double bevel = 0.15e-3;
  for (const char* name : {"block", "bracket", "hinge", "linkarm", "sprocket"}) {
    const Shape shape = load(name, 5.0);
    const Mesh mesh = makeMesh(shape, bevel);
    double volume = 0.0;
    Eigen::Vector3d outward = Eigen::Vector3d::Zero();
    for (const auto& face : mesh.faces) {
      const Eigen::Vector3d a = mesh.points[face[0]].cast<double>(),
                            b = mesh.points[face[1]].cast<double>(),
                            c = mesh.points[face[2]].cast<double>();
      volume += a.dot(b.cross(c)) / 6.0;
      outward += 0.5 * (b - a).cross(c - a);
    }
    // A closed surface has no area to any side in sum; single precision leaves some mm^2 1e-3.
    EXPECT_LT(outward.norm(), 2e-8) << name;
    // The bevels take less than a thousandth.
    EXPECT_NEAR(volume / (area(shape) * shape.thickness), 1.0, 2e-3) << name;
  }
}

TEST(ConvexPieces, CoverTheShape) {
  const Shape shape = load("bracket", 3.0, 3e-4);
  const double slack = 5e-6;
  const auto pieces = convexPieces(shape, slack);
  double sum = 0.0;
  for (const Polygon& piece : pieces) sum += area(piece);
  EXPECT_GT(sum, area(shape) - 1e-9);
  EXPECT_LT(sum, area(shape) + slack * static_cast<double>(pieces.size()));
  EXPECT_LT(pieces.size(), 40u);
  for (const Polygon& piece : pieces) {
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const Eigen::Vector2d a = piece[i], b = piece[(i + 1) % piece.size()],
                            c = piece[(i + 2) % piece.size()];
      EXPECT_GE((b - a).x() * (c - b).y() - (b - a).y() * (c - b).x(), -1e-12);
    }
  }
}

}  // namespace
}  // namespace planar_bin_picking::cell
