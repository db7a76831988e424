// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
// Every parameter of the views changes what a look says.

#include "planar_bin_picking/views/look.h"

#include "support/looked_bracket.h"

#include <gtest/gtest.h>

#include <set>

namespace planar_bin_picking {
namespace {

LookResult look(const LocatorParams& params, const Eigen::Isometry3d& known) {
  const sim::Scene scene = bracketAt(sim::poseOf(kLie));
  return Looker(params).look(
      knownAt(known), *kBracket,
      {viewOf(scene, Eigen::Isometry3d::Identity(), 1), viewOf(scene, orbit(kCentre, 30, 20), 2)});
}

TEST(ViewKeys, EachCounts) {
  struct Change {
    std::string key;
    double value;
  };
  const std::vector<Change> changes = {{"views/robot_sigma", 1e-3},
                                       {"views/robot_sigma_deg", 0.2},
                                       {"views/hand_eye_sigma", 2e-3},
                                       {"views/hand_eye_sigma_deg", 0.4},
                                       {"views/depth_reach", 0.09}};
  std::set<std::string> known, tried;
  LocatorParams params;
  forEachField(params, [&](const std::string& key, auto&&...) {
    if (key.rfind("views/", 0) == 0) known.insert(key);
  });
  for (const Change& change : changes) tried.insert(change.key);
  EXPECT_EQ(tried, known);
  const Eigen::Isometry3d truth = sim::poseOf(kLie);
  Eigen::Isometry3d off = truth;
  off.translation() *= 1.0 + 0.07 / kCentre.norm();  // too far for the default reach
  for (const Change& change : changes) {
    LocatorParams changed;
    forEachField(changed, [&](const std::string& key, auto& member, auto&&...) {
      if (key == change.key) member = static_cast<std::decay_t<decltype(member)>>(change.value);
    });
    const auto& start = change.key == "views/depth_reach" ? off : truth;
    const auto usual = look({}, start);
    const auto other = look(changed, start);
    if (change.key == "views/depth_reach") {
      EXPECT_EQ(usual.status, LookStatus::kContradicted);
      EXPECT_EQ(other.status, LookStatus::kCorrected);
    } else {
      const auto place = [](const LookResult& result) {
        return result.detection.covariance.topLeftCorner<3, 3>().trace();
      };
      EXPECT_GT(place(other), 1.1 * place(usual)) << change.key;
    }
  }
}

}  // namespace
}  // namespace planar_bin_picking
