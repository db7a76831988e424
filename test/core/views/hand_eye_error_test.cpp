// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/hand_eye_error.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

TEST(HandEyeError, IsTheCalibratorsPerAxis) {
  // As the calibrator writes it.
  const HandEyeError error = loadHandEyeError(PACKAGE_DIR "/test/ros/calibration/hand_eye.yaml");
  EXPECT_NEAR(error.metres, 1e-4 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(error.degrees, 0.01 / std::sqrt(3.0), 1e-12);
}

TEST(HandEyeError, RefusesWhatSaysNone) {
  TempDir dir;
  const HandEyeError none =
      loadHandEyeError(dir.write("exact.yaml", "expected_error_mm: 0\nexpected_error_deg: 0.0\n"));
  EXPECT_EQ(none.metres, 0.0);
  EXPECT_EQ(none.degrees, 0.0);
  const auto load = [&](const std::string& yaml) {
    return [path = dir.write("hand_eye.yaml", yaml)] { loadHandEyeError(path); };
  };
  EXPECT_TRUE(refuses(load("expected_error_mm: 0.1\n"), {"hand_eye.yaml", "expected_error_deg"}));
  EXPECT_TRUE(refuses(load("expected_error_mm: -1\nexpected_error_deg: 0\n"),
                      {"expected_error_mm", "at least 0"}));
  EXPECT_TRUE(
      refuses(load("expected_error_mm: .nan\nexpected_error_deg: 0\n"), {"expected_error_mm"}));
  EXPECT_TRUE(refuses([&] { loadHandEyeError(dir.path("none.yaml")); }, {"none.yaml"}));
}

}  // namespace
}  // namespace planar_bin_picking
