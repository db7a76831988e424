// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/mistakes.h"

#include "base/scatter.h"
#include "calibrate/board/board_views.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <locale>
#include <sstream>

namespace planar_bin_picking {
namespace {

constexpr double kPi = 3.14159265358979323846, kRadians = kPi / 180.0;
constexpr double kNoFit = std::numeric_limits<double>::infinity();
/// Fewer views fit anything.
constexpr std::size_t kFewest = 5;

/// A closed form that fits the pictures leaves less than this, pixels: a robot of 5 mm and 1 deg,
/// which is refused for that, leaves some 3 % of the image.
double fitsBelow(const HandEyeProblem& problem) {
  return 0.02 * std::max(problem.width, problem.height);
}

struct Fit {
  double error_px = kNoFit;  // median over the views
  Chain chain;
};

Fit fit(const HandEyeProblem& problem, const Intrinsics& intrinsics, const HandEyeParams& params,
        const std::vector<Observation>& observations, const std::vector<PosePair>& pairs) {
  Fit out;
  const auto chains = closedForms(problem, pairs, intrinsics, params, true);
  if (chains.empty()) return out;
  out.chain = chains.front();
  std::vector<double> errors;
  for (const Observation& observation : observations) {
    const auto r = residuals(out.chain, problem.board, observation, Vector6d::Zero());
    errors.push_back(r.empty() ? kNoFit : rms(r));
  }
  out.error_px = median(errors);
  return out;
}

/// What a pose may have been before the mistake; more than one where it is not unique.
using Undo = std::function<std::vector<Eigen::Isometry3d>(const Eigen::Isometry3d&)>;

std::vector<Eigen::Isometry3d> withRotations(const Eigen::Isometry3d& T,
                                             const std::vector<Eigen::Matrix3d>& rotations) {
  std::vector<Eigen::Isometry3d> out;
  for (const Eigen::Matrix3d& R : rotations) out.push_back(rigid(R, T.translation()));
  return out;
}

/// Rotation vectors of one rotation of up to a whole turn.
std::vector<Eigen::Vector3d> vectorsOf(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d w = rotationVector(R);
  const double angle = w.norm();
  if (angle < 1e-9) return {w};
  return {w, w * (1.0 - 2.0 * kPi / angle)};
}

Eigen::Matrix3d turn(int axis, double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
}

Eigen::Matrix3d ofVector(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

/// Three numbers that were angles about x, y, z (or z, y, x) and were taken for a rotation vector.
Undo anglesTakenForVector(bool x_last_turn, bool z_first) {
  return [x_last_turn, z_first](const Eigen::Isometry3d& T) {
    std::vector<Eigen::Matrix3d> rotations;
    for (const Eigen::Vector3d& w : vectorsOf(T.linear())) {
      const double x = z_first ? w.z() : w.x(), z = z_first ? w.x() : w.z();
      rotations.push_back(x_last_turn ? Eigen::Matrix3d(turn(0, x) * turn(1, w.y()) * turn(2, z))
                                      : Eigen::Matrix3d(turn(2, z) * turn(1, w.y()) * turn(0, x)));
    }
    return withRotations(T, rotations);
  };
}

/// A rotation vector whose numbers were taken for roll, pitch and yaw.
std::vector<Eigen::Isometry3d> vectorTakenForAngles(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d& R = T.linear();
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  const double roll = std::atan2(R(2, 1), R(2, 2)), yaw = std::atan2(R(1, 0), R(0, 0));
  std::vector<Eigen::Matrix3d> rotations;
  const auto other = [](double angle) { return angle > 0.0 ? angle - kPi : angle + kPi; };
  rotations.push_back(ofVector({roll, pitch, yaw}));
  rotations.push_back(
      ofVector({other(roll), pitch > 0.0 ? kPi - pitch : -kPi - pitch, other(yaw)}));
  return withRotations(T, rotations);
}

/// The numbers of a quaternion w x y z that were read as x y z w.
std::vector<Eigen::Isometry3d> realPartFirst(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  return withRotations(T, {Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).toRotationMatrix()});
}

/// All observations with a pose of the board, and these poses.
struct Views {
  std::vector<Observation> observations;
  std::vector<Eigen::Isometry3d> boards;  // T_camera_board
};

double angleDifference(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                       const Eigen::Isometry3d& board_a, const Eigen::Isometry3d& board_b) {
  // The angle does not depend on which side the poses are inverted.
  const double robot = rotationAngle(a.linear().transpose() * b.linear());
  const double board = rotationAngle(board_a.linear() * board_b.linear().transpose());
  // A wrong pair must not outweigh the others.
  return std::min(0.2, std::abs(robot - board));
}

struct Choice {
  double cost = kNoFit;
  std::vector<Eigen::Isometry3d> poses;
};

/// Of each view the candidate that costs least against the others, by coordinate descent from one
/// candidate of the first view.
Choice chooseFrom(const Eigen::Isometry3d& first,
                  const std::vector<std::vector<Eigen::Isometry3d>>& candidates,
                  const std::vector<Eigen::Isometry3d>& boards) {
  Choice choice{0.0, {first}};
  const auto costOf = [&](std::size_t i, const Eigen::Isometry3d& candidate) {
    double cost = 0.0;
    for (std::size_t k = 0; k < choice.poses.size(); ++k) {
      if (k != i) cost += angleDifference(candidate, choice.poses[k], boards[i], boards[k]);
    }
    return cost;
  };
  const auto bestOf = [&](std::size_t i) {
    return *std::min_element(
        candidates[i].begin(), candidates[i].end(),
        [&](const auto& a, const auto& b) { return costOf(i, a) < costOf(i, b); });
  };
  for (std::size_t i = 1; i < candidates.size(); ++i) choice.poses.push_back(bestOf(i));
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < candidates.size(); ++i) choice.poses[i] = bestOf(i);
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) choice.cost += costOf(i, choice.poses[i]);
  return choice;
}

/// The candidate of each view by which the robot turns as the board does.
std::vector<Eigen::Isometry3d> choose(const std::vector<std::vector<Eigen::Isometry3d>>& candidates,
                                      const std::vector<Eigen::Isometry3d>& boards) {
  Choice best;
  for (const Eigen::Isometry3d& first : candidates.front()) {
    Choice choice = chooseFrom(first, candidates, boards);
    if (choice.cost < best.cost) best = std::move(choice);
  }
  return best.poses;
}

Fit fitWith(const HandEyeProblem& problem, const Intrinsics& intrinsics,
            const HandEyeParams& params, const Views& views, const Undo& undo) {
  std::vector<std::vector<Eigen::Isometry3d>> candidates;
  for (const Observation& o : views.observations) candidates.push_back(undo(o.T_base_flange));
  const std::vector<Eigen::Isometry3d> poses = choose(candidates, views.boards);
  std::vector<Observation> observations = views.observations;
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    observations[i].T_base_flange = poses[i];
    pairs.push_back({robotSide(problem.mounting, poses[i]), views.boards[i]});
  }
  const Camera::Model camera =
      problem.camera ? *problem.camera : toModel(intrinsics, problem.width, problem.height);
  const auto all = orderings(problem.board);
  const std::vector<std::size_t> chosen = chooseOrderings(pairs, problem.board);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (chosen[i] == 0) continue;
    observations[i].corners = reordered(observations[i].corners, all[chosen[i]]);
    pairs[i].board =
        boardPose(camera, seenPoints(problem.board, observations[i])).value_or(pairs[i].board);
  }
  return fit(problem, intrinsics, params, observations, pairs);
}

/// Poses the wrong way round and the other mounting are one and the same to the pictures. Which it
/// is follows from what is nearer to the flange: a robot carries a camera, or a board, at arm's
/// length.
std::string nameDirection(const HandEyeProblem& problem, const Chain& chain) {
  const bool in_hand = problem.mounting == Mounting::kEyeInHand;
  const bool camera_on_flange =
      chain.T_mount_camera.translation().norm() < chain.T_other_board.translation().norm();
  const std::string inverted =
      "robot poses inverted: they are T_flange_base; give T_base_flange, the flange in the base";
  const std::string mounting = std::string("other mounting: ") +
                               (in_hand ? "the camera stands still and the board is on the flange; "
                                          "set the mode to eye_to_hand"
                                        : "the camera is on the flange and the board stands still; "
                                          "set the mode to eye_in_hand");
  const bool is_inverted = camera_on_flange == in_hand;
  return (is_inverted ? inverted : mounting) + " (the pictures fit then; they would likewise if " +
         (is_inverted ? "the mounting were the other one)" : "the poses were inverted)");
}

std::string nameUnit(double scale) {
  struct Unit {
    const char* name;
    double per_metre;
  };
  // A square that is stated wrongly is not off by such a factor.
  constexpr double kTolerance = 1.15;
  for (const Unit& unit :
       {Unit{"millimetres", 1000.0}, {"centimetres", 100.0}, {"inches", 39.37}}) {
    const double ratio = scale / unit.per_metre;
    if (!(ratio > 1.0 / kTolerance && ratio < kTolerance)) continue;
    return std::string(unit.name) + " for metres: the positions of the robot poses are in " +
           unit.name + "; give metres";
  }
  return "";
}

Views viewsOf(const HandEyeProblem& problem, const Intrinsics& intrinsics) {
  const Camera::Model camera =
      problem.camera ? *problem.camera : toModel(intrinsics, problem.width, problem.height);
  Views views;
  for (const Observation& observation : problem.observations) {
    const auto T_camera_board = boardPose(camera, seenPoints(problem.board, observation));
    if (!T_camera_board) continue;
    views.observations.push_back(observation);
    views.boards.push_back(*T_camera_board);
  }
  return views;
}

}  // namespace

bool areLateByOne(const HandEyeProblem& problem, const Intrinsics& intrinsics,
                  const HandEyeParams& params, const std::vector<Observation>& observations,
                  const std::vector<PosePair>& pairs) {
  if (pairs.size() < kFewest + 1) return false;
  std::vector<Observation> late;
  std::vector<PosePair> late_pairs;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    late.push_back(observations[i - 1]);
    late.back().T_base_flange = observations[i].T_base_flange;
    late_pairs.push_back({pairs[i].robot, pairs[i - 1].board});
  }
  // Poses that are right fit far worse when they are shifted, late ones far better.
  constexpr double kFarBetter = 0.35;
  const double shifted = fit(problem, intrinsics, params, late, late_pairs).error_px;
  return shifted < fitsBelow(problem) &&
         shifted < kFarBetter * fit(problem, intrinsics, params, observations, pairs).error_px;
}

std::string nameMistake(const HandEyeProblem& problem, const Intrinsics& intrinsics,
                        const HandEyeParams& params) {
  const Views views = viewsOf(problem, intrinsics);
  if (views.observations.size() < kFewest) return "";
  const auto same = [](const Eigen::Isometry3d& T) { return std::vector<Eigen::Isometry3d>{T}; };
  const Fit as_given = fitWith(problem, intrinsics, params, views, same);
  const double fits_px = fitsBelow(problem);
  if (as_given.error_px < fits_px) return nameUnit(as_given.chain.scale);
  constexpr double kFarBetter = 0.25;
  const double limit = std::min(fits_px, kFarBetter * as_given.error_px);
  Fit best;
  std::string name;
  const auto attempt = [&](const Undo& undo, const std::string& text) {
    const Fit trial = fitWith(problem, intrinsics, params, views, undo);
    if (!(trial.error_px < limit && trial.error_px < best.error_px)) return;
    best = trial;
    name = text.empty() ? nameDirection(problem, trial.chain) : text;
  };
  attempt([](const Eigen::Isometry3d& T) { return std::vector<Eigen::Isometry3d>{T.inverse()}; },
          "");
  attempt(realPartFirst,
          "quaternion order: the numbers are w x y z; give x y z w, the real part last");
  const std::string angles =
      "Euler angles taken for a rotation vector: the orientations are angles about ";
  attempt(anglesTakenForVector(false, false),
          angles + "x, y, z (roll, pitch, yaw: R = Rz Ry Rx); convert them as such");
  attempt(anglesTakenForVector(true, false),
          angles + "x, y', z'' (R = Rx Ry Rz); convert them as such");
  attempt(anglesTakenForVector(false, true),
          angles + "z, y', x'' (A, B, C: R = Rz Ry Rx); convert them as such");
  attempt(
      vectorTakenForAngles,
      "rotation vector taken for Euler angles: the orientations are rotation vectors (axis times "
      "angle); convert them as such");
  return name;
}

std::string nameTurnFault(const std::vector<Observation>& observations, double second_axis_deg,
                          const HandEyeParams& params) {
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  int count = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const Eigen::Vector3d w = rotationVector(observations[i].T_base_flange.linear() *
                                               observations[k].T_base_flange.linear().transpose());
      square += w * w.transpose();
      ++count;
    }
  }
  if (count == 0) return "";
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(square / count);
  const double first_deg = std::sqrt(std::max(0.0, eigen.eigenvalues()[2])) / kRadians;
  const double second_deg = std::sqrt(std::max(0.0, eigen.eigenvalues()[1])) / kRadians;
  const bool is_upright = std::abs(eigen.eigenvectors()(2, 2)) > std::cos(5.0 * kRadians);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  // A robot with four axes keeps its flange upright as well as it is built.
  constexpr double kUprightDeg = 0.5;
  const bool is_four_axis = second_deg < kUprightDeg && is_upright;
  if (params.four_axis
          ? first_deg < 2.0 * params.axes_min_deg
          : first_deg < 2.0 * params.axes_min_deg && second_axis_deg < params.axes_min_deg) {
    text << "views too much alike: the robot turned by " << first_deg
         << " deg RMS, and about a second "
         << "axis by " << second_axis_deg << " deg, needed are " << params.axes_min_deg
         << " deg; allow a larger workspace and cone, and tilt the flange by 20 deg and more";
  } else if (params.four_axis && !is_four_axis) {
    text << "four_axis is set, but the robot turned by " << second_deg
         << " deg RMS about an axis that is not the base's z; set four_axis to false";
  } else if (params.four_axis || second_axis_deg >= params.axes_min_deg) {
    return "";
  } else if (is_four_axis) {
    text << "4-axis robot: it turns about the vertical axis alone (rotations about one axis; the "
            "second is turned about by "
         << second_deg
         << " deg RMS), so that the camera's height stays open; touch the middle of the board with "
            "the robot and give its height as board_z, with four_axis true; or tilt the flange if "
            "the robot can";
  } else {
    text << "rotations about one axis: the second axis is turned about by " << second_axis_deg
         << " deg RMS, needed are " << params.axes_min_deg
         << " deg; tilt the flange about two different axes by 20 deg and more";
  }
  return text.str();
}

}  // namespace planar_bin_picking
