// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hand_eye/calibration_age.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <ctime>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::refuses;
using planar_bin_picking::TempDir;

std::string daysAgo(int days) {
  const std::time_t seconds = std::time(nullptr) - 86400 * days;
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&seconds));
  return text;
}

TEST(CalibrationAge, PoorIsRefusedUnlessAccepted) {
  const TempDir dir;
  const std::string path = dir.write("hand_eye.yaml", "parent_frame: flange\n");
  EXPECT_NO_THROW(checkUsable(path, false, 0.0));
  dir.write("calibration.yaml", "verdict: POOR\n");
  EXPECT_TRUE(refuses([&] { checkUsable(path, false, 0.0); }, {"POOR", "accept_poor_calibration"}));
  EXPECT_NO_THROW(checkUsable(path, true, 0.0));
  // What the file says of itself counts first.
  dir.write("hand_eye.yaml", "verdict: GOOD\n");
  EXPECT_NO_THROW(checkUsable(path, false, 0.0));
}

TEST(CalibrationAge, RefusedIsRefusedAlways) {
  const TempDir dir;
  const std::string path = dir.write("hand_eye.yaml", "parent_frame: flange\n");
  dir.write("calibration.yaml", "verdict: REFUSED\n");
  EXPECT_TRUE(refuses([&] { checkUsable(path, true, 0.0); }, {"REFUSED", "calibrate anew"}));
  // It could not be renamed any more when the power went.
  dir.write("hand_eye.yaml", "verdict: GOOD\n");
  EXPECT_TRUE(refuses([&] { checkUsable(path, true, 0.0); }, {"REFUSED", "calibrate anew"}));
}

TEST(CalibrationAge, ExpiredIsRefused) {
  const TempDir dir;
  const std::string path = dir.write("hand_eye.yaml", "date: " + daysAgo(40) + "\n");
  EXPECT_NO_THROW(checkUsable(path, false, 0.0));
  EXPECT_NO_THROW(checkUsable(path, false, 41.0));
  EXPECT_TRUE(refuses([&] { checkUsable(path, false, 30.0); },
                      {"40 days old", "allowed are 30", "~verify", "calibration_max_age_days"}));
  dir.write("hand_eye.yaml", "parent_frame: flange\n");
  EXPECT_NO_THROW(checkUsable(path, false, 1.0));  // written just now
  dir.write("calibration.yaml", "date: " + daysAgo(2) + "\n");
  EXPECT_TRUE(refuses([&] { checkUsable(path, false, 1.0); }, {"2 days old"}));
  dir.write("calibration.yaml", "date: yesterday\n");
  EXPECT_TRUE(refuses([&] { checkUsable(path, false, 1.0); }, {"yesterday", "must be as"}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
