// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/part_summary.h"

#include "support/comma_locale.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <yaml-cpp/yaml.h>

namespace planar_bin_picking {
namespace {

PartSummary bracketSummary() {
  PartFile file = makePart("bracket", bracketPlate())->file();
  file.drawing.units = "mm";
  file.drawing.left_out = {"layer DIM: 14 entities", "layer A: b: 1 entity"};
  file.drawing.warnings = {"first"};
  file.warnings = {"second"};
  PickPose pick;
  pick.name = "suction";
  pick.face = FaceFilter::kBack;
  file.pick_poses = {pick};
  return describePart(PartModel(file));
}

TEST(PartSummary, HasWhatWasRead) {
  const PartSummary summary = bracketSummary();
  EXPECT_EQ(summary.part, "bracket");
  EXPECT_EQ(summary.units, "mm");
  EXPECT_NEAR(summary.size_mm.x(), 80.0, 1e-9);
  EXPECT_NEAR(summary.size_mm.y(), 50.0, 1e-9);
  // The L less its two holes of r 6 and r 4, drawn with 180 corners.
  EXPECT_NEAR(summary.area_mm2, 80.0 * 20 + 30 * 30 - 3.14159 * (36 + 16), 0.1);
  EXPECT_EQ(summary.holes, 2);
  EXPECT_EQ(summary.prints, 0);
  EXPECT_EQ(summary.symmetry_order, 1);
  EXPECT_FALSE(summary.mirror_symmetric);
  EXPECT_EQ(summary.pick_poses, std::vector<std::string>{"suction"});
  EXPECT_EQ(summary.left_out.size(), 2u);
  EXPECT_EQ(summary.warnings, (std::vector<std::string>{"first", "second"}));
}

TEST(PartSummary, OfASymmetricPart) {
  PartFile file = makePart("wheel", wheelPlate(6, false))->file();
  file.pick_poses.resize(1);
  file.pick_poses[0].name = "web";
  file.pick_poses[0].face = FaceFilter::kBack;
  const PartSummary summary = describePart(PartModel(file));
  EXPECT_EQ(summary.symmetry_order, 6);
  EXPECT_TRUE(summary.mirror_symmetric);
  // The copies that its symmetry makes were not written by anybody.
  EXPECT_EQ(summary.pick_poses, std::vector<std::string>{"web"});
  EXPECT_NE(toLine(summary).find("6-fold and mirror symmetry"), std::string::npos);
  const PartSummary printed = describePart(*makePart("printed", printedPlate()));
  EXPECT_EQ(printed.prints, 1);
  EXPECT_NE(toLine(printed).find("4 holes, 1 print, "), std::string::npos);
  EXPECT_NE(toLine(describePart(*makePart("disk", {circle(0, 0, 30), {}, {}, 0.0}))).find("round"),
            std::string::npos);
}

TEST(PartSummary, IsOneYamlMapInOrder) {
  const std::string yaml = toYaml(bracketSummary());
  const YAML::Node root = YAML::Load(yaml);
  std::vector<std::string> keys;
  for (const auto& entry : root) keys.push_back(entry.first.Scalar());
  EXPECT_EQ(keys, (std::vector<std::string>{"part", "units", "size_mm", "area_mm2", "holes",
                                            "prints", "symmetry_order", "mirror_symmetric",
                                            "pick_poses", "left_out", "warnings"}));
  EXPECT_EQ(root["left_out"][1].as<std::string>(), "layer A: b: 1 entity");
  EXPECT_NE(yaml.find("left_out: ['layer DIM: 14 entities', "), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("size_mm: [80.000, 50.000]\n"), std::string::npos) << yaml;
}

TEST(PartSummary, IsOneLineForALog) {
  EXPECT_EQ(toLine(bracketSummary()),
            "80.0 x 50.0 mm, 2 holes, no symmetry, 1 pick pose, left out: layer DIM (14 "
            "entities), layer A: b (1 entity)");
  PartSummary inches;
  inches.size_mm = {25.4, 12.7};
  inches.units = "inch";
  inches.mirror_symmetric = true;
  EXPECT_EQ(toLine(inches),
            "25.4 x 12.7 mm (drawn in inch), 0 holes, mirror symmetry, 0 pick poses");
}

TEST(PartSummary, HasPointsInEveryLocale) {
  const CommaLocale commas;
  const std::string yaml = toYaml(bracketSummary());
  EXPECT_NE(yaml.find("size_mm: [80.000, 50.000]\n"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("area_mm2: 2336."), std::string::npos) << yaml;
  EXPECT_EQ(toLine(bracketSummary()).find("80.0 x 50.0 mm"), 0u);
}

}  // namespace
}  // namespace planar_bin_picking
