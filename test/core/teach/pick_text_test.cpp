// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "teach/pick_text.h"

#include "planar_bin_picking/part/part_file.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

using Poses = std::vector<PickPose>;

Poses read(const std::string& text) { return pickPosesIn(text, "part.yaml"); }

PickPose shifted(PickPose pose, double x_mm) {
  pose.T_part_pick.translation().x() += 1e-3 * x_mm;
  return pose;
}

PickPose named(PickPose pose, const std::string& name) {
  pose.name = name;
  return pose;
}

const char kByHand[] =
    "# a lever\n"
    "drawing: lever.dxf   # from the customer\n"
    "pick_poses:          # the preferred one first\n"
    "  # the web\n"
    "  - {name: web, face: front, position_mm: [30, 20, 0], rpy_deg: [180, 0, 0]}  # soft cup\n"
    "\n"
    "  # the eye\n"
    "  - name: 'eye'\n"
    "    face: \"back\"\n"
    "    # measured in May\n"
    "    position_mm: [10.5, 20, -3]   # to the rim\n"
    "    symmetric: false\n"
    "  # nothing at the tip\n"
    "\n"
    "# thickness as delivered\n"
    "thickness_mm: 3.0\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(PickText, WhatHasNotChangedStaysByteForByte) {
  Poses poses = read(kByHand);
  EXPECT_EQ(withPickPoses(kByHand, poses), kByHand);
  poses[0] = shifted(poses[0], 1e-4);  // less than is written
  EXPECT_EQ(withPickPoses(kByHand, poses), kByHand);
}

TEST(PickText, OnlyTheChangedNumbersAreWritten) {
  Poses poses = read(kByHand);
  poses[0] = shifted(poses[0], 0.1254);
  EXPECT_EQ(withPickPoses(kByHand, poses), replaced(kByHand, "[30, 20, 0]", "[30.125, 20, 0]"));
  poses = read(kByHand);
  poses[0].T_part_pick.rotate(Eigen::AngleAxisd(EIGEN_PI / 6, Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(withPickPoses(kByHand, poses), replaced(kByHand, "[180, 0, 0]", "[180, 0, -30]"));
  poses = read(kByHand);
  poses[1] = shifted(poses[1], -0.5);
  poses[1].face = FaceFilter::kFront;  // and turned, with a key that was not there
  poses[1].T_part_pick.rotate(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
  std::string expected = replaced(kByHand, "[10.5, 20, -3]", "[10, 20, -3]");
  expected = replaced(expected, "\"back\"", "\"front\"");
  expected = replaced(expected, "# to the rim\n", "# to the rim\n    rpy_deg: [180, 0, 0]\n");
  EXPECT_EQ(withPickPoses(kByHand, poses), expected);
}

TEST(PickText, ARenamedPoseKeepsItsPlaceAndItsComments) {
  Poses poses = read(kByHand);
  poses[0].name = "cup, soft";
  poses[0] = shifted(poses[0], 1.0);
  poses[1].name = "web";  // what the other one was called
  std::string expected = replaced(kByHand, "name: web,", "name: \"cup, soft\",");
  expected = replaced(expected, "'eye'", "web");
  expected = replaced(expected, "[30, 20, 0]", "[31, 20, 0]");
  const auto refusal = [&] { withPickPoses(kByHand, poses, {{"cup, soft", "web"}}); };
  EXPECT_TRUE(refuses(refusal, {"a word without @ and /"}));
  poses[0].name = "cup";
  expected = replaced(expected, "\"cup, soft\"", "cup");
  EXPECT_EQ(withPickPoses(kByHand, poses, {{"cup", "web"}, {"web", "eye"}}), expected);
  const std::string alias =
      "drawing: a.dxf\npick_poses:\n  - {name: &n a, face: back, position_mm: [1, 2, 3]}\n";
  EXPECT_TRUE(refuses(
      [&] {
        withPickPoses(alias, {named(read(alias)[0], "b")}, {{"b", "a"}});
      },
      {"write the name a as that word"}));
}

TEST(PickText, PosesComeAndGo) {
  Poses poses = read(kByHand);
  poses.push_back(named(shifted(poses[1], 5), "tip-2"));
  const std::string added =
      "  - {name: tip-2, face: back, position_mm: [15.5, 20, -3], rpy_deg: [0, 0, 0], symmetric: "
      "false}\n";
  const std::string more =
      replaced(kByHand, "    symmetric: false\n", "    symmetric: false\n" + added);
  EXPECT_EQ(withPickPoses(kByHand, poses), more);
  poses.erase(poses.begin() + 1);
  const std::string other = replaced(
      more,
      "  - name: 'eye'\n    face: \"back\"\n    # measured in May\n    position_mm: [10.5, "
      "20, -3]   # to the rim\n    symmetric: false\n",
      "");
  EXPECT_EQ(withPickPoses(more, poses), other);
  const std::string none = withPickPoses(kByHand, {});
  EXPECT_TRUE(read(none).empty());
  for (const char* kept : {"# a lever", "# from the customer", "pick_poses: []          # the pref",
                           "# the web", "# the eye", "# nothing at the tip\n\n# thickness"})
    EXPECT_NE(none.find(kept), std::string::npos) << kept << " is not in\n" << none;
  const std::string again = withPickPoses(none, {poses[0]});
  EXPECT_EQ(read(again).size(), 1u) << again;
}

TEST(PickText, TheOrderOfPreferenceIsChanged) {
  const Poses poses = read(kByHand), turned(poses.rbegin(), poses.rend());
  const std::string other = withPickPoses(kByHand, turned);
  EXPECT_EQ(read(other).front().name, "eye");
  // Each keeps what stands in its own lines; comments between them stay where they are.
  EXPECT_NE(other.find("  # the web\n  - name: 'eye'\n"), std::string::npos) << other;
  EXPECT_NE(other.find("[30, 20, 0], rpy_deg: [180, 0, 0]}  # soft cup\n  # nothing at the tip"),
            std::string::npos)
      << other;
  EXPECT_EQ(withPickPoses(other, poses), kByHand);
  // Moved, changed and joined by a new one in one go.
  Poses three = turned;
  three[0] = shifted(three[0], 1.0);
  three.insert(three.begin() + 1, named(shifted(poses[0], 7), "tip"));
  const Poses again = read(withPickPoses(kByHand, three));
  ASSERT_EQ(again.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(isSamePick(again[i], three[i])) << i;
  // In brackets, and where the last line is open.
  const std::string flow =
      "pick_poses: [{name: a, face: back, position_mm: [1, 2, 3]}, {name: b, face: back, "
      "position_mm: [4, 5, 6]}]\ndrawing: a.dxf\n";
  const Poses two = read(flow), back(two.rbegin(), two.rend());
  EXPECT_EQ(read(withPickPoses(flow, back)).front().name, "b");
  const std::string open =
      "drawing: a.dxf\npick_poses:\n- {name: a, face: back, position_mm: [1, 2, 3]}\n"
      "- {name: b, face: back, position_mm: [4, 5, 6]}";
  EXPECT_EQ(withPickPoses(open, back),
            "drawing: a.dxf\npick_poses:\n- {name: b, face: back, position_mm: [4, 5, 6]}\n"
            "- {name: a, face: back, position_mm: [1, 2, 3]}");
}

TEST(PickText, AFileWithoutPosesGetsThemAtItsEnd) {
  const Poses poses = {read(kByHand)[0]};
  const std::string entry =
      "  - {name: web, face: front, position_mm: [30, 20, 0], rpy_deg: [180, 0, 0]}";
  EXPECT_EQ(withPickPoses("drawing: a.dxf", poses), "drawing: a.dxf\npick_poses:\n" + entry + "\n");
  EXPECT_EQ(withPickPoses("drawing: a.dxf\r\n# end\r\n", poses),
            "drawing: a.dxf\r\n# end\r\npick_poses:\r\n" + entry + "\r\n");
  EXPECT_EQ(withPickPoses("\xEF\xBB\xBF"
                          "drawing: a.dxf\n",
                          poses),
            "\xEF\xBB\xBF"
            "drawing: a.dxf\npick_poses:\n" +
                entry + "\n");
  EXPECT_EQ(withPickPoses("drawing: a.dxf\npick_poses: []  # none\nunits: mm\n", poses),
            "drawing: a.dxf\npick_poses:\n" + entry + "  # none\nunits: mm\n");
}

TEST(PickText, OneLineListsAreRead) {
  const std::string text =
      "pick_poses: [{name: a, face: back, position_mm: [1, 2, 3]}, {name: b, face: back, "
      "position_mm: [4, 5, 6]}]\ndrawing: a.dxf\n";
  Poses poses = read(text);
  poses[1] = shifted(poses[1], 0.25);
  EXPECT_EQ(withPickPoses(text, poses), replaced(text, "[4,", "[4.25,"));
  poses.erase(poses.begin());
  EXPECT_EQ(
      withPickPoses(text, poses),
      "pick_poses:\n  - {name: b, face: back, position_mm: [4.25, 5, 6], rpy_deg: [0, 0, 0]}\n"
      "drawing: a.dxf\n");
}

TEST(PickText, ListsAtTheMarginAndOpenEndsAreRead) {
  const std::string text =
      "drawing: a.dxf\npick_poses:\n- name: a\n  face: back\n  position_mm: [1, 2, 3]";
  Poses poses = read(text);
  poses[0].T_part_pick.rotate(Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitZ()));
  poses.push_back(named(poses[0], "b"));
  EXPECT_EQ(withPickPoses(text, poses),
            text +
                "\n  rpy_deg: [0, 0, 90]\n- {name: b, face: back, position_mm: [1, 2, 3], rpy_deg: "
                "[0, 0, 90]}\n");
}

TEST(PickText, WhatCannotBeDoneSafelyIsRefused) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& words) {
    Poses poses = read(text);
    for (PickPose& pose : poses) pose = shifted(pose, 7);
    if (!poses.empty()) poses.erase(poses.begin());
    poses.push_back(named(read(kByHand)[0], "new"));
    return refuses([&] { withPickPoses(text, poses); }, words);
  };
  EXPECT_TRUE(refused("{drawing: a.dxf}", {"pick_poses", "braces"}));
  EXPECT_TRUE(refused("drawing: a.dxf\npick_poses: [ # here\n]\n", {"brackets"}));
  EXPECT_TRUE(refused("drawing: a.dxf\npick_poses: &all []\n", {"brackets"}));
  // One place for two poses, one of which moves, or goes.
  const std::string shared =
      "drawing: a.dxf\npick_poses:\n  - {name: a, face: back, position_mm: &p [1, 2, 3]}\n"
      "  - {name: b, face: back, position_mm: *p}\n";
  EXPECT_TRUE(refused(shared, {"three numbers in brackets"}));
  EXPECT_TRUE(refuses([&] { withPickPoses(shared, {read(shared)[1]}); }, {"anchors"}));
  EXPECT_TRUE(
      refused("drawing: a.dxf\npick_poses:\n  - name: a\n    face: back\n    position_mm: [1, "
              "2, 3]\n  - name: b\n    face: back\n    position_mm:\n      - 1\n      - 2\n"
              "      - 3\n",
              {"three numbers in brackets"}));
  // Behind the document's end nobody reads.
  EXPECT_TRUE(refused("drawing: a.dxf\n...\n", {"would not be read"}));
  // A pose that nobody could read again.
  PickPose wrong = read(kByHand)[1];
  wrong.face = FaceFilter::kFront;
  EXPECT_TRUE(
      refuses([&] { withPickPoses("drawing: a.dxf\n", {wrong}); }, {"point into the part"}));
}

}  // namespace
}  // namespace planar_bin_picking
