// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// The keys below `run` and `solver` of config/calibrator.yaml: changed in the parameters as ROS
/// has them, each changes what its comment there says.

#include "calibrator/calibrator_params.h"
#include "support/matchers.h"
#include "support/simulated_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::HandEyeProblem;
using planar_bin_picking::HandEyeResult;
using planar_bin_picking::RunOutcome;
using planar_bin_picking::RunWorld;
using planar_bin_picking::Verdict;
using XmlRpc::XmlRpcValue;
namespace sim = planar_bin_picking::sim;

/// Parameters with one key changed, which stands below `run` or `solver`, or several.
CalibratorParams with(const std::vector<std::pair<std::string, XmlRpcValue>>& changes) {
  XmlRpcValue tree;
  tree["square"] = 0.02;
  tree["output_folder"] = "calibration";
  for (const char* axis : {"x", "y", "z"}) {
    tree["run"][std::string("workspace_min_") + axis] = -2.0;
    tree["run"][std::string("workspace_max_") + axis] = 2.0;
  }
  for (const auto& [key, value] : changes) {
    const auto slash = key.find('/');
    tree[key.substr(0, slash)][key.substr(slash + 1)] = value;
  }
  return loadCalibratorParams(tree);
}

double degreesBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) / sim::kDegree;
}

// --- run
// ------------------------------------------------------------------------------------------

class RunKeys : public testing::Test {
 protected:
  static RunWorld world() { return RunWorld(true, 3); }
  static RunOutcome outcomeOf(const CalibratorParams& params) {
    RunWorld here = world();
    return here.run(params.run, params.solver);
  }
  static const RunOutcome& byDefault() {
    static const RunOutcome outcome = outcomeOf(with({}));
    return outcome;
  }
  static bool asksTheSame(const RunOutcome& a, const RunOutcome& b) {
    if (a.asked.size() != b.asked.size()) return false;
    for (std::size_t i = 0; i < a.asked.size(); ++i) {
      if (!a.asked[i].isApprox(b.asked[i], 1e-12)) return false;
    }
    return true;
  }
};

/// How far from the start flange and camera get along an axis.
double mountedReach(const RunOutcome& outcome, int axis, double sign) {
  const RunWorld here(true, 3);
  double most = -1e9;
  for (const auto& T : outcome.commands) {
    for (const Eigen::Vector3d& x :
         {T.translation().eval(), (T * here.cell.T_mount_camera.translation()).eval()}) {
      most = std::max(most, sign * (x - here.T_base_start.translation())[axis]);
    }
  }
  return most;
}

TEST_F(RunKeys, WorkspaceBoundsEachWay) {
  const Eigen::Vector3d start = world().T_base_start.translation();
  int binding = 0;
  const std::string ends[3][2] = {{"run/workspace_min_x", "run/workspace_max_x"},
                                  {"run/workspace_min_y", "run/workspace_max_y"},
                                  {"run/workspace_min_z", "run/workspace_max_z"}};
  for (int axis = 0; axis < 3; ++axis) {
    // What is mounted needs room, too.
    const auto down = outcomeOf(with({{ends[axis][0], XmlRpcValue(start[axis] - 0.34)}}));
    const auto up = outcomeOf(with({{ends[axis][1], XmlRpcValue(start[axis] + 0.34)}}));
    EXPECT_LE(mountedReach(down, axis, -1.0), 0.34) << ends[axis][0];
    EXPECT_LE(mountedReach(up, axis, 1.0), 0.34) << ends[axis][1];
    binding += !asksTheSame(down, byDefault()) + !asksTheSame(up, byDefault());
  }
  EXPECT_GE(binding, 4);  // it would go there otherwise
}

TEST_F(RunKeys, ConeDeg) {
  const auto lean = [](const RunOutcome& outcome) {
    double most = 0.0;
    for (const auto& T : outcome.asked) {
      most = std::max(most, degreesBetween(T.linear().col(2), outcome.asked[0].linear().col(2)));
    }
    return most;
  };
  EXPECT_LE(lean(outcomeOf(with({{"run/cone_deg", 12.0}}))), 12.0 + 1e-6);
  EXPECT_GT(lean(byDefault()), 15.0);
}

TEST_F(RunKeys, MaxRollDeg) {
  const auto roll = [](const RunOutcome& outcome) {
    double most = 0.0;
    for (const auto& T : outcome.asked) {
      const Eigen::Matrix3d R = outcome.asked[0].linear().transpose() * T.linear();
      const Eigen::Matrix3d level =
          Eigen::Quaterniond::FromTwoVectors(R.col(2), Eigen::Vector3d::UnitZ()) * R;
      most = std::max(most, std::abs(std::atan2(level(1, 0), level(0, 0))) / sim::kDegree);
    }
    return most;
  };
  EXPECT_LE(roll(outcomeOf(with({{"run/max_roll_deg", 20.0}}))), 20.0 + 1e-6);
  EXPECT_GT(roll(byDefault()), 25.0);
}

TEST_F(RunKeys, MaxStepAndTurn) {
  const auto steps = [](const RunOutcome& outcome) {
    double metres = 0.0, degrees = 0.0;
    for (std::size_t i = 0; i < outcome.commands.size(); ++i) {
      const Eigen::Isometry3d step = outcome.stood[i].inverse() * outcome.commands[i];
      metres = std::max(metres, step.translation().norm());
      degrees = std::max(degrees, planar_bin_picking::rotationAngle(step.linear()) / sim::kDegree);
    }
    return std::pair(metres, degrees);
  };
  EXPECT_LE(steps(byDefault()).first, 0.1 + 1e-9);
  EXPECT_GT(steps(byDefault()).first, 0.05);
  EXPECT_LE(steps(byDefault()).second, 15.0 + 1e-6);
  EXPECT_LE(steps(outcomeOf(with({{"run/max_step_m", 0.02}}))).first, 0.02 + 1e-9);
  EXPECT_LE(steps(outcomeOf(with({{"run/max_turn_deg", 5.0}}))).second, 5.0 + 1e-6);
}

/// The six faces of a box about the start, as planes.
std::vector<XmlRpcValue> planesAbout(double distance) {
  std::vector<XmlRpcValue> planes;
  const Eigen::Vector3d start = RunWorld(true, 3).T_base_start.translation();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      XmlRpcValue plane;
      for (int i = 0; i < 3; ++i) plane[i] = i == axis ? -sign : 0.0;
      plane[3] = -sign * start[axis] - distance;
      planes.push_back(plane);
    }
  }
  return planes;
}

TEST_F(RunKeys, Planes) {
  const std::vector<XmlRpcValue> planes = planesAbout(0.34);
  int binding = 0;
  for (int i = 0; i < 6; ++i) {
    const RunOutcome outcome = outcomeOf(with({{"run/planes", planes[static_cast<size_t>(i)]}}));
    EXPECT_LE(mountedReach(outcome, i / 2, i % 2 == 0 ? -1.0 : 1.0), 0.34) << i;
    binding += asksTheSame(outcome, byDefault()) ? 0 : 1;
  }
  EXPECT_GE(binding, 3);
}

TEST_F(RunKeys, MountedRadiusAndClearance) {
  RunWorld tight = world();
  const double reach = tight.cell.T_mount_camera.translation().norm();
  const RunOutcome wrong = outcomeOf(with({{"run/mounted_radius_m", reach - 0.05}}));
  EXPECT_NE(wrong.failure.find("correct mounted_radius_m"), std::string::npos) << wrong.failure;
  EXPECT_EQ(byDefault().failure, "");
  const std::vector<XmlRpcValue> planes = planesAbout(0.34);
  int binding = 0;
  for (int i = 0; i < 6; ++i) {
    const auto reach = [&](double clearance) {
      const auto params = with({{"run/planes", planes[static_cast<size_t>(i)]},
                                {"run/clearance_m", clearance},
                                {"run/views_max", 9}});
      return mountedReach(outcomeOf(params), i / 2, i % 2 == 0 ? -1.0 : 1.0);
    };
    binding += reach(0.0) > reach(0.2) + 0.02 ? 1 : 0;
  }
  EXPECT_GE(binding, 2);
}

TEST_F(RunKeys, RefusalsMax) {
  const auto refusals = [](int most) {
    RunWorld here = world();
    here.failing = 1.0;
    const CalibratorParams params = with({{"run/refusals_max", most}});
    return here.run(params.run, params.solver);
  };
  EXPECT_EQ(refusals(3).refused, 3);
  EXPECT_EQ(refusals(5).refused, 5);
  EXPECT_EQ(refusals(5).end, planar_bin_picking::CalibrationRun::End::kRefusals);
}

TEST_F(RunKeys, FirstTurnDeg) {
  const auto turn = [](const RunOutcome& outcome) {
    return planar_bin_picking::rotationAngle(
               (outcome.asked[0].inverse() * outcome.asked[1]).linear()) /
           sim::kDegree;
  };
  EXPECT_NEAR(turn(byDefault()), 8.0, 1e-6);
  EXPECT_NEAR(turn(outcomeOf(with({{"run/first_turn_deg", 4.0}}))), 4.0, 1e-6);
}

TEST_F(RunKeys, TiltMaxDeg) {
  const auto tilt = [](const RunOutcome& outcome) {
    const RunWorld here = world();
    double most = 0.0;
    for (std::size_t i = 8; i < outcome.asked.size(); ++i) {
      const Eigen::Isometry3d T_camera_board = here.cell.cameraBoard(outcome.asked[i]);
      most = std::max(most, degreesBetween(T_camera_board.linear().col(2), {0.0, 0.0, 1.0}));
    }
    return most;
  };
  const auto many = [](double deg) {
    return outcomeOf(with({{"run/tilt_max_deg", deg}, {"solver/tolerance_mm", 0.001}}));
  };
  EXPECT_LT(tilt(many(15.0)), 17.0);  // the solution is provisional
  EXPECT_GT(tilt(many(40.0)), 20.0);
}

TEST_F(RunKeys, MarginPx) {
  const auto margin = [](const RunOutcome& outcome) {
    double least = 1e9;
    const auto& views = outcome.problem.observations;
    for (std::size_t i = 8; i < views.size(); ++i) {
      for (const Eigen::Vector2d& p : views[i].corners) {
        least = std::min(
            {least, p.x(), p.y(), outcome.problem.width - p.x(), outcome.problem.height - p.y()});
      }
    }
    return least;
  };
  const auto many = [](double px) {
    return outcomeOf(with({{"run/margin_px", px}, {"solver/tolerance_mm", 0.001}}));
  };
  EXPECT_GT(margin(many(300.0)), 280.0);
  EXPECT_LT(margin(many(20.0)), 280.0);
}

TEST_F(RunKeys, ViewsMaxAndAttemptsMax) {
  const auto never = std::pair<std::string, XmlRpcValue>("solver/tolerance_mm", 0.001);
  EXPECT_EQ(outcomeOf(with({never})).pictures, 15);
  EXPECT_EQ(outcomeOf(with({never, {"run/views_max", 11}})).pictures, 11);
  EXPECT_EQ(outcomeOf(with({never, {"run/attempts_max", 9}})).asked.size(), 9u);
}

TEST_F(RunKeys, CandidatesAndSeedChooseOtherViews) {
  EXPECT_TRUE(asksTheSame(byDefault(), outcomeOf(with({{"run/seed", 1}}))));
  EXPECT_FALSE(asksTheSame(byDefault(), outcomeOf(with({{"run/seed", 2}}))));
  EXPECT_TRUE(asksTheSame(byDefault(), outcomeOf(with({{"run/candidates", 150}}))));
  EXPECT_FALSE(asksTheSame(byDefault(), outcomeOf(with({{"run/candidates", 10}}))));
}

// --- solver
// ---------------------------------------------------------------------------------------

class SolverKeys : public testing::Test {
 protected:
  /// Fifteen views with a robot of 0.3 mm and 0.05 deg.
  SolverKeys() : cell_(sim::makeCell(true, &random_)) {
    cell_.robot_mm = 0.3;
    cell_.robot_deg = 0.05;
    problem_ = planar_bin_picking::randomProblem(cell_, 15, &random_);
  }
  HandEyeResult solve(const std::vector<std::pair<std::string, XmlRpcValue>>& changes) const {
    return solveHandEye(problem_, with(changes).solver);
  }
  static bool says(const HandEyeResult& result, const std::string& words) {
    for (const std::string& reason : result.reasons) {
      if (reason.find(words) != std::string::npos) return true;
    }
    return false;
  }

  std::mt19937 random_{11};
  sim::BoardCell cell_;
  HandEyeProblem problem_;
};

TEST_F(SolverKeys, MinViews) {
  EXPECT_EQ(solve({}).verdict, Verdict::kGood);
  const HandEyeResult result = solve({{"solver/min_views", 20}});
  EXPECT_EQ(result.verdict, Verdict::kRefused);
  EXPECT_TRUE(says(result, "needed are 20"));
}

TEST_F(SolverKeys, FourAxis) {
  // These views turn about several axes.
  const HandEyeResult result = solve({{"solver/four_axis", true}});
  EXPECT_EQ(result.verdict, Verdict::kRefused);
  EXPECT_TRUE(says(result, "four_axis is set"));
  const HandEyeResult higher = solve(
      {{"solver/four_axis", true}, {"solver/board_z", 0.3}, {"solver/board_z_sigma_mm", 0.01}});
  ASSERT_TRUE(higher.solved);
  const Eigen::Vector3d middle = higher.T_other_board * cell_.centre();
  EXPECT_NEAR(middle.z(), 0.3, 0.05);
  EXPECT_NE(higher.notes.front().find("0.3 m +- 0.01 mm"), std::string::npos);
}

TEST_F(SolverKeys, RobotSigma) {
  const HandEyeResult result =
      solve({{"solver/robot_sigma_mm", 0.7}, {"solver/robot_sigma_deg", 0.15}});
  EXPECT_NEAR(result.robot_mm, 0.7, 1e-9);
  EXPECT_NEAR(result.robot_deg, 0.15, 1e-9);
  const HandEyeResult estimated = solve({});
  EXPECT_NEAR(estimated.robot_mm, 0.3, 0.15);
  EXPECT_NEAR(estimated.robot_deg, 0.05, 0.025);
}

TEST_F(SolverKeys, AxesMinDeg) {
  const HandEyeResult result = solve({{"solver/axes_min_deg", 80.0}});
  EXPECT_EQ(result.verdict, Verdict::kRefused);
  EXPECT_TRUE(says(result, "needed are 80 deg"));
}

// Pairs that turn by more do not count for the second axis either. Those that turn by less are left
// out of the closed form alone, from which the same solution is reached.
TEST_F(SolverKeys, PairAngles) {
  const HandEyeResult all = solve({{"solver/pair_angle_max_deg", 180.0}});
  const HandEyeResult small = solve({{"solver/pair_angle_max_deg", 90.0}});
  EXPECT_GT(std::abs(small.axes_deg - all.axes_deg), 0.05);  // 0 where it is ignored
  const HandEyeResult large = solve({{"solver/pair_angle_min_deg", 60.0}});
  EXPECT_TRUE(planar_bin_picking::isometryNear(large.T_mount_camera, all.T_mount_camera, 1e-4,
                                               0.01 * sim::kDegree));
}

TEST_F(SolverKeys, WrongPairDeg) {
  auto& T = problem_.observations[4].T_base_flange;
  T.linear() = T.linear() *
               Eigen::AngleAxisd(2.0 * sim::kDegree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const std::string words = "turn by angles that differ";
  EXPECT_EQ(solve({}).views[4].why_not.find(words), std::string::npos);
  const std::string why_not = solve({{"solver/wrong_pair_deg", 1.0}}).views[4].why_not;
  EXPECT_NE(why_not.find(words), std::string::npos) << why_not;
}

TEST_F(SolverKeys, RobotPoorAndRefused) {
  EXPECT_EQ(solve({{"solver/robot_poor_mm", 0.1}}).verdict, Verdict::kPoor);
  EXPECT_EQ(solve({{"solver/robot_poor_deg", 0.02}}).verdict, Verdict::kPoor);
  EXPECT_EQ(solve({{"solver/robot_refused_mm", 0.1}}).verdict, Verdict::kRefused);
  EXPECT_EQ(solve({{"solver/robot_refused_deg", 0.02}}).verdict, Verdict::kRefused);
  EXPECT_TRUE(says(solve({{"solver/robot_refused_mm", 0.1}}), "robot noise too large"));
}

TEST_F(SolverKeys, ScaleTolerance) {
  problem_.board.square *= 1.012;
  EXPECT_EQ(solve({}).verdict, Verdict::kPoor);
  const HandEyeResult result = solve({{"solver/scale_tolerance", 0.005}});
  EXPECT_EQ(result.verdict, Verdict::kRefused);
  EXPECT_TRUE(says(result, "square size wrong"));
}

TEST_F(SolverKeys, Tolerances) {
  const HandEyeResult mm = solve({{"solver/tolerance_mm", 0.01}});
  EXPECT_EQ(mm.verdict, Verdict::kPoor);
  EXPECT_TRUE(says(mm, "allowed are 0.01 mm"));
  const HandEyeResult deg = solve({{"solver/tolerance_deg", 0.001}});
  EXPECT_EQ(deg.verdict, Verdict::kPoor);
  EXPECT_TRUE(says(deg, "and 0.001 deg"));
}

TEST_F(SolverKeys, WorkingDistance) {
  const HandEyeResult as_boards = solve({}), far = solve({{"solver/working_distance", 3.0}});
  EXPECT_DOUBLE_EQ(far.working_distance, 3.0);
  EXPECT_LT(as_boards.working_distance, 1.0);
  EXPECT_GT(far.expected_error_mm, 1.5 * as_boards.expected_error_mm);
}

}  // namespace
}  // namespace planar_bin_picking_ros
