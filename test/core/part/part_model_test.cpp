// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/part_model.h"

#include "base/polygon.h"
#include "support/matchers.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <limits>

namespace planar_bin_picking {
namespace {

/// Whether there is material at a point, metres.
bool onMaterial(const PartModel& part, const Eigen::Vector2d& p) {
  const auto& loops = part.file().drawing.loops;
  bool inside = contains(loops.front().points, p);
  for (const Loop& loop : loops) {
    if (loop.kind == LoopKind::kHole && contains(loop.points, p)) inside = false;
  }
  return inside;
}

TEST(PartModel, ManyAreLoadedInTheOrderGiven) {
  const std::string folder = std::string(PACKAGE_DIR) + "/test/data/parts/";
  std::vector<std::string> paths;
  for (int i = 0; i < 5; ++i)
    for (const char* name : {"sprocket.yaml", "missing.dxf", "block.yaml"})
      paths.push_back(folder + name);
  const auto loaded = loadParts(paths);
  ASSERT_EQ(loaded.size(), paths.size());
  for (std::size_t i = 0; i < loaded.size(); ++i) {
    if (i % 3 == 1) {
      EXPECT_EQ(loaded[i].part, nullptr);
      EXPECT_NE(loaded[i].error.find("missing.dxf"), std::string::npos) << loaded[i].error;
    } else {
      ASSERT_NE(loaded[i].part, nullptr) << loaded[i].error;
      EXPECT_EQ(loaded[i].part->name(), i % 3 == 0 ? "sprocket" : "block");
    }
  }
  EXPECT_TRUE(loadParts({}).empty());
}

TEST(PartModel, SamplesAreEvenAlongEachLoop) {
  const auto part = makePart("bracket", bracketPlate());
  const auto& outline = part->outline();
  // 260 mm of sides and 20 pi mm of holes.
  EXPECT_NEAR(outline.size(), 512.0, 2.0);
  const double spacing = 1e-3 * (260.0 + 20.0 * 3.14159265) / 512.0;
  for (std::size_t i = 1; i < outline.size(); ++i) {
    if (outline[i].loop != outline[i - 1].loop) continue;
    const double step = (outline[i].position - outline[i - 1].position).norm();
    const bool turns = outline[i].normal.dot(outline[i - 1].normal) < 0.999;
    // A loop's count is rounded: 5 % for the small hole's 41 samples. A chord cuts a corner.
    EXPECT_LT(step, 1.05 * spacing) << i;
    EXPECT_GT(step, turns ? 0.0 : 0.95 * spacing) << i;
  }
}

TEST(PartModel, LoopsComeInOrderWithTheirKind) {
  const auto part = makePart("printed", printedPlate());
  int last = 0;
  for (const OutlinePoint& p : part->outline()) {
    EXPECT_GE(p.loop, last);
    last = p.loop;
    EXPECT_EQ(p.kind, p.loop == 0  ? LoopKind::kOuter
                      : p.loop < 5 ? LoopKind::kHole
                                   : LoopKind::kPrint);
  }
  EXPECT_EQ(last, 5);
  EXPECT_TRUE(part->hasPrint());
  EXPECT_FALSE(makePart("bracket", bracketPlate())->hasPrint());
}

TEST(PartModel, NormalsPointOutOfTheMaterial) {
  for (const auto& plate : {bracketPlate(), wheelPlate(15, true)}) {
    const auto part = makePart("part", plate);
    for (const OutlinePoint& p : part->outline()) {
      EXPECT_NEAR(p.normal.norm(), 1.0, 1e-12);
      EXPECT_FALSE(onMaterial(*part, p.position + 1e-5 * p.normal)) << p.position.transpose();
      EXPECT_TRUE(onMaterial(*part, p.position - 1e-5 * p.normal)) << p.position.transpose();
    }
  }
}

TEST(PartModel, SmallLoopsStillHaveSamples) {
  sim::Plate plate{rectangle(-200, -150, 200, 150), {circle(0, 0, 1, true)}, {}, 0.0};
  const auto part = makePart("plate", plate);
  int hole = 0;
  for (const OutlinePoint& p : part->outline()) hole += p.kind == LoopKind::kHole ? 1 : 0;
  EXPECT_EQ(hole, 12);
}

TEST(PartModel, CenterAndRadiusAreThoseOfTheOuterContour) {
  const auto part = makePart("bracket", bracketPlate());
  EXPECT_LT((part->center() - Eigen::Vector2d(0.007, -0.004)).norm(), 1e-12);
  EXPECT_NEAR(part->radius(), 1e-3 * std::hypot(40.0, 25.0), 1e-12);
}

TEST(PartModel, FacesLieAThicknessApart) {
  sim::Plate plate = bracketPlate();
  plate.thickness_mm = 3.0;
  const auto part = makePart("bracket", plate);
  EXPECT_EQ(part->thickness(), 3e-3);
  EXPECT_EQ(part->faceZ(Face::kFront), 0.0);
  EXPECT_EQ(part->faceZ(Face::kBack), -3e-3);
}

TEST(PartModel, AWheelsNearOrderIsThatOfItsTeeth) {
  EXPECT_EQ(makePart("wheel", wheelPlate(15, true))->nearOrder(), 15);
  EXPECT_EQ(makePart("wheel", wheelPlate(13, true))->nearOrder(), 13);
  EXPECT_EQ(makePart("wheel", wheelPlate(15, false))->nearOrder(), 15);
  EXPECT_EQ(makePart("bracket", bracketPlate())->nearOrder(), 1);
  EXPECT_EQ(makePart("printed", printedPlate())->nearOrder(), 4);
  EXPECT_EQ(makePart("ring", {circle(0, 0, 30), {circle(0, 0, 10, true)}, {}, 0.0})->nearOrder(),
            0);
}

TEST(PartModel, RefusesWhatIsNoPart) {
  PartFile file;
  file.name = "thing";
  EXPECT_TRUE(refuses([&] { PartModel part(file); }, {"thing", "no outer contour"}));
  file.drawing.loops = {{LoopKind::kHole, true, {{0.0, 0.0}, {0.01, 0.0}, {0.0, 0.01}}}};
  EXPECT_TRUE(refuses([&] { PartModel part(file); }, {"thing", "no outer contour"}));
  file.drawing.loops[0].kind = LoopKind::kOuter;
  PartFile point = file;
  point.drawing.loops[0].points = {{0.01, 0.01}, {0.01, 0.01}};
  EXPECT_TRUE(refuses([&] { PartModel part(point); }, {"thing", "no extent"}));
  file.thickness = -1e-3;
  EXPECT_TRUE(refuses([&] { PartModel part(file); }, {"thing", "thickness"}));
  file.thickness = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refuses([&] { PartModel part(file); }, {"thing", "thickness"}));
}

/// Drawings of sites have their origin anywhere.
TEST(PartModel, IsTheSameFarFromTheOrigin) {
  const Eigen::Vector2d off(8e3, -7e3);  // 10 km
  PartFile file = makePart("wheel", wheelPlate(15, true))->file();
  const PartModel near(file);
  for (Loop& loop : file.drawing.loops) {
    for (auto& p : loop.points) p += off;
  }
  const PartModel far(file);
  EXPECT_EQ(far.symmetry().mirror, near.symmetry().mirror);
  EXPECT_EQ(far.symmetry().order, near.symmetry().order);
  EXPECT_EQ(far.nearOrder(), near.nearOrder());
  EXPECT_NEAR(far.radius(), near.radius(), 1e-8);
  EXPECT_LT((far.center() - near.center() - off).norm(), 1e-8);
  ASSERT_EQ(far.outline().size(), near.outline().size());
  for (std::size_t i = 0; i < far.outline().size(); ++i) {
    EXPECT_LT((far.outline()[i].position - near.outline()[i].position - off).norm(), 1e-8);
    EXPECT_LT((far.outline()[i].normal - near.outline()[i].normal).norm(), 1e-5);
  }
  EXPECT_EQ(far.faceGrid().cells().size(), near.faceGrid().cells().size());
  ASSERT_EQ(far.nearSymmetries().size(), near.nearSymmetries().size());
  for (std::size_t i = 0; i < far.nearSymmetries().size(); ++i) {
    const Eigen::Isometry3d moved = Eigen::Translation3d(off.x(), off.y(), 0.0) *
                                    near.nearSymmetries()[i].T_part_turned *
                                    Eigen::Translation3d(-off.x(), -off.y(), 0.0);
    const Eigen::Vector3d p(off.x() + 0.03, off.y(), 0.0);
    EXPECT_LT((far.nearSymmetries()[i].T_part_turned * p - moved * p).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace planar_bin_picking
