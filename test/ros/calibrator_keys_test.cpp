// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// Each key of config/calibrator.yaml below `solver` and `run`, loaded as the node loads it,
/// changes what the calibration asks for or how it ends, in the simulated cell.

#include "calibrator_params.h"
#include "support/simulated_run.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <set>
#include <sstream>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::HandEyeResult;
using planar_bin_picking::RunWorld;
using XmlRpc::XmlRpcValue;

using Values = std::map<std::string, XmlRpcValue>;

struct Change {
  std::string key;
  XmlRpcValue value;
  Values others = {};  ///< that must be set for it to be allowed
};

CalibratorParams load(const Values& values) {
  XmlRpcValue tree;
  tree["square"] = 0.02;
  tree["output_folder"] = "out";
  for (const auto& [key, value] : values) {
    const auto slash = key.find('/');
    tree[key.substr(0, slash)][key.substr(slash + 1)] = value;
  }
  return loadCalibratorParams(tree);
}

/// To the last digit: the pairs of views only make the start of an optimization.
void print(const HandEyeResult& result, std::ostream& out) {
  out.precision(17);
  out << nameOf(result.verdict) << " " << result.expected_error_mm << " "
      << result.expected_error_deg << "\n"
      << result.T_mount_camera.matrix() << "\n";
  for (const std::string& reason : result.reasons) out << reason << "\n";
}

/// Enough noise of the robot, and a square that is stated wrong enough, for every limit to matter.
std::string solve(const CalibratorParams& params) {
  std::mt19937 random(4);
  auto cell = planar_bin_picking::sim::makeCell(true, &random);
  cell.robot_mm = 0.3;
  cell.robot_deg = 0.1;
  auto problem = planar_bin_picking::randomProblem(cell, 12, &random);
  problem.board.square *= 1.01;
  std::ostringstream text;
  print(planar_bin_picking::solveHandEye(problem, params.solver), text);
  return text.str();
}

std::string run(const CalibratorParams& params) {
  RunWorld world(true, 3);
  const auto outcome = world.run(params.run, params.solver);
  std::ostringstream text;
  for (const Eigen::Isometry3d& T : outcome.asked) text << T.matrix() << "\n";
  print(outcome.result, text);
  return text.str();
}

std::set<std::string> keysOf(const std::string& section) {
  const YAML::Node root = YAML::LoadFile(std::string(PACKAGE_DIR) + "/config/calibrator.yaml");
  std::set<std::string> keys;
  for (const auto& entry : root[section])
    keys.insert(section + "/" + entry.first.as<std::string>());
  return keys;
}

void expectEachMatters(const std::vector<Change>& changes, const std::string& section,
                       std::string (*outcomeOf)(const CalibratorParams&)) {
  const std::string defaults = outcomeOf(load({}));
  EXPECT_EQ(outcomeOf(load({})), defaults);
  std::set<std::string> tried;
  for (const Change& change : changes) {
    Values values = change.others;
    const std::string before = values.empty() ? defaults : outcomeOf(load(values));
    values[change.key] = change.value;
    EXPECT_NE(outcomeOf(load(values)), before) << change.key;
    tried.insert(change.key);
  }
  EXPECT_EQ(tried, keysOf(section));
}

TEST(CalibratorKeys, OfTheSolverChangeTheVerdict) {
  const Values kRobot = {{"solver/robot_sigma_mm", 0.3}, {"solver/robot_sigma_deg", 0.1}};
  expectEachMatters({{"solver/min_views", 13},
                     {"solver/robot_sigma_mm", 2.0, kRobot},
                     {"solver/robot_sigma_deg", 0.5, kRobot},
                     {"solver/axes_min_deg", 80.0},
                     {"solver/pair_angle_min_deg", 90.0},
                     {"solver/pair_angle_max_deg", 90.0},
                     {"solver/wrong_pair_deg", 0.1},
                     {"solver/robot_poor_mm", 0.05},
                     {"solver/robot_poor_deg", 0.02},
                     {"solver/robot_refused_mm", 0.05},
                     {"solver/robot_refused_deg", 0.02},
                     {"solver/scale_tolerance", 0.002},
                     {"solver/tolerance_mm", 0.01},
                     {"solver/tolerance_deg", 0.001},
                     {"solver/working_distance", 1.5}},
                    "solver", solve);
}

TEST(CalibratorKeys, OfTheRunChangeItsPoses) {
  const Eigen::Vector3d start = RunWorld(true, 3).T_base_start.translation();
  constexpr double kRoom = 0.02;  // metres about the start, less than the views are apart
  expectEachMatters({{"run/workspace_min_x", start.x() - kRoom},
                     {"run/workspace_min_y", start.y() - kRoom},
                     {"run/workspace_min_z", start.z() - kRoom},
                     {"run/workspace_max_x", start.x() + kRoom},
                     {"run/workspace_max_y", start.y() + kRoom},
                     {"run/workspace_max_z", start.z() + kRoom},
                     {"run/cone_deg", 10.0},
                     {"run/first_turn_deg", 4.0},
                     {"run/tilt_max_deg", 15.0},
                     {"run/margin_px", 300.0},
                     {"run/views_max", 5},
                     {"run/attempts_max", 5},
                     {"run/candidates", 40},
                     {"run/seed", 2}},
                    "run", run);
}

}  // namespace
}  // namespace planar_bin_picking_ros
