// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/closed_form.h"

#include "base/scatter.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <opencv2/calib3d.hpp>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;

struct RelativePair {
  Eigen::Isometry3d robot, board;  // G_i G_j^-1 and C_i C_j^-1
};

std::vector<RelativePair> usefulPairs(const std::vector<PosePair>& motions,
                                      const HandEyeParams& params) {
  std::vector<RelativePair> pairs;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const RelativePair pair{motions[i].robot * motions[j].robot.inverse(),
                              motions[i].board * motions[j].board.inverse()};
      const double angle = rotationAngle(pair.robot.linear());
      if (angle < params.pair_angle_min_deg * kRadians) continue;
      if (angle > params.pair_angle_max_deg * kRadians) continue;
      pairs.push_back(pair);
    }
  }
  return pairs;
}

/// Rotation that turns the board's rotation vectors into the robot's, then the translation (and
/// scale) from (R_A - I) t_X - s R_X t_B = -t_A.
std::optional<Chain> fromPairs(const std::vector<RelativePair>& pairs, bool free_scale) {
  if (pairs.size() < 2) return std::nullopt;
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const RelativePair& pair : pairs) {
    M += rotationVector(pair.robot.linear()) * rotationVector(pair.board.linear()).transpose();
  }
  const Eigen::Matrix3d R = nearestRotation(M);
  const auto rows = 3 * static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd A(rows, free_scale ? 4 : 3);
  Eigen::VectorXd b(rows);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Vector3d turned = R * pairs[i].board.translation();
    A.block<3, 3>(at, 0) = pairs[i].robot.linear() - Eigen::Matrix3d::Identity();
    b.segment<3>(at) = -pairs[i].robot.translation();
    if (free_scale) {
      A.block<3, 1>(at, 3) = -turned;
    } else {
      b.segment<3>(at) += turned;
    }
  }
  const Eigen::VectorXd x = A.colPivHouseholderQr().solve(b);
  Chain chain;
  chain.T_mount_camera = rigid(R, x.head<3>());
  chain.scale = free_scale ? x[3] : 1.0;
  // Millimetres given for metres are a factor of 1000.
  constexpr double kScaleMost = 1e4;
  if (!x.allFinite()) return std::nullopt;
  if (!(chain.scale > 1.0 / kScaleMost && chain.scale < kScaleMost)) return std::nullopt;
  return chain;
}

/// For a robot that turns about z alone: the camera's tilt from the axis about which the board
/// turns, its yaw and place across from (R_A - I) t_X - s Rz R t_B = -t_A. How high it is stays
/// open.
/// @param up  the axis, in the mount's frame
std::optional<Chain> fromUprightPairs(const std::vector<PosePair>& motions,
                                      const Eigen::Vector3d& up, bool free_scale) {
  const Eigen::Isometry3d upright =
      rigid(Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
            Eigen::Vector3d::Zero());
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  // z as the camera has it
  Eigen::MatrixXd A(0, 4);
  std::vector<RelativePair> pairs;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      pairs.push_back({upright * motions[i].robot * motions[k].robot.inverse() * upright.inverse(),
                       motions[i].board * motions[k].board.inverse()});
      const Eigen::Vector3d robot = rotationVector(pairs.back().robot.linear());
      axis += robot.z() * rotationVector(pairs.back().board.linear());
    }
  }
  if (!(axis.norm() > 0.0)) return std::nullopt;
  const Eigen::Matrix3d tilt =
      Eigen::Quaterniond::FromTwoVectors(axis, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const auto rows = 2 * static_cast<Eigen::Index>(pairs.size());
  A.resize(rows, 4);
  Eigen::VectorXd b(rows);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto at = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector3d t = tilt * pairs[i].board.translation();
    A.block<2, 2>(at, 0) =
        pairs[i].robot.linear().topLeftCorner<2, 2>() - Eigen::Matrix2d::Identity();
    A.block<2, 2>(at, 2) << -t.x(), t.y(), -t.y(), -t.x();
    b.segment<2>(at) = -pairs[i].robot.translation().head<2>();
  }
  // x, y, and cosine and sine of the yaw times the scale.
  const Eigen::VectorXd x = A.colPivHouseholderQr().solve(b);
  const double scale = x.tail<2>().norm();
  if (!x.allFinite() || !(scale > 0.0)) return std::nullopt;
  Chain chain;
  const Eigen::AngleAxisd yaw(std::atan2(x[3], x[2]), Eigen::Vector3d::UnitZ());
  chain.T_mount_camera =
      upright.inverse() * rigid(yaw.toRotationMatrix() * tilt, {x[0], x[1], 0.0});
  chain.scale = free_scale ? scale : 1.0;
  return chain;
}

std::optional<Eigen::Isometry3d> fromOpenCv(const std::vector<PosePair>& motions,
                                            cv::HandEyeCalibrationMethod method) {
  std::vector<cv::Mat> R_robot, t_robot, R_board, t_board;
  const auto add = [](const Eigen::Isometry3d& T, std::vector<cv::Mat>* R,
                      std::vector<cv::Mat>* t) {
    cv::Mat_<double> rotation(3, 3), translation(3, 1);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) rotation(i, k) = T.linear()(i, k);
      translation(i) = T.translation()[i];
    }
    R->push_back(rotation);
    t->push_back(translation);
  };
  for (const PosePair& motion : motions) {
    add(motion.robot.inverse(), &R_robot, &t_robot);
    add(motion.board, &R_board, &t_board);
  }
  cv::Mat_<double> R, t;
  try {
    cv::calibrateHandEye(R_robot, t_robot, R_board, t_board, R, t, method);
  } catch (const cv::Exception&) {
    return std::nullopt;  // this method has no answer; there are others
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) T.linear()(i, k) = R(i, k);
    T.translation()[i] = t(i);
  }
  if (!T.matrix().allFinite()) return std::nullopt;
  T.linear() = nearestRotation(T.linear());
  return T;
}

/// The board's place on its side of the chain, as most of the views have it.
Eigen::Isometry3d otherBoard(const std::vector<PosePair>& motions,
                             const Eigen::Isometry3d& T_mount_camera, double scale) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
  std::array<std::vector<double>, 3> t;
  for (const PosePair& motion : motions) {
    Eigen::Isometry3d C = motion.board;
    C.translation() *= scale;
    const Eigen::Isometry3d Z = motion.robot.inverse() * T_mount_camera * C;
    R += Z.linear();
    for (std::size_t k = 0; k < 3; ++k) t[k].push_back(Z.translation()[static_cast<int>(k)]);
  }
  Eigen::Vector3d middle;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = t[k].begin() + static_cast<std::ptrdiff_t>(t[k].size() / 2);
    std::nth_element(t[k].begin(), at, t[k].end());
    middle[static_cast<int>(k)] = *at;
  }
  return rigid(nearestRotation(R), middle);
}

/// A board turned onto its ordering k: T_camera_board of the reordered corners is T * turn(k).
Eigen::Matrix3d turnOf(std::size_t k, std::size_t count) {
  const double angle =
      2.0 * 3.14159265358979323846 * static_cast<double>(k) / static_cast<double>(count);
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

double angleError(const PosePair& a, const PosePair& b, const Eigen::Matrix3d& turn) {
  const double robot = rotationAngle(a.robot.linear() * b.robot.linear().transpose());
  const double board = rotationAngle(a.board.linear() * turn * b.board.linear().transpose());
  return std::abs(robot - board);
}

}  // namespace

Eigen::Isometry3d robotSide(Mounting mounting, const Eigen::Isometry3d& T_base_flange) {
  return mounting == Mounting::kEyeInHand ? T_base_flange.inverse() : T_base_flange;
}

std::vector<std::size_t> chooseOrderings(const std::vector<PosePair>& motions, const Board& board) {
  const std::size_t count = orderings(board).size();
  std::vector<std::size_t> chosen(motions.size(), 0);
  if (count == 1) return chosen;
  // Coordinate descent: each view in turn takes the ordering that fits those before it, then all
  // others.
  for (int round = 0; round < 5; ++round) {
    bool changed = false;
    for (std::size_t i = 1; i < motions.size(); ++i) {
      std::vector<double> cost(count, 0.0);
      for (std::size_t j = 0; j < (round == 0 ? i : motions.size()); ++j) {
        if (j == i) continue;
        for (std::size_t k = 0; k < count; ++k) {
          const std::size_t between = (k + count - chosen[j]) % count;
          // A wrong pair must not outweigh the others.
          cost[k] += std::min(0.2, angleError(motions[i], motions[j], turnOf(between, count)));
        }
      }
      const auto best =
          static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
      changed = changed || best != chosen[i];
      chosen[i] = best;
    }
    if (!changed && round > 0) break;
  }
  return chosen;
}

std::vector<Eigen::Vector2d> reordered(const std::vector<Eigen::Vector2d>& corners,
                                       const std::vector<std::size_t>& ordering) {
  std::vector<Eigen::Vector2d> out;
  for (const std::size_t i : ordering) out.push_back(corners[i]);
  return out;
}

std::vector<double> angleErrors(const std::vector<PosePair>& motions) {
  std::vector<double> out;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    std::vector<double> errors;
    for (std::size_t j = 0; j < motions.size(); ++j) {
      if (j != i) errors.push_back(angleError(motions[i], motions[j], Eigen::Matrix3d::Identity()));
    }
    out.push_back(median(errors));
  }
  return out;
}

double secondAxis(const std::vector<PosePair>& motions, const HandEyeParams& params) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  int count = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d a =
          rotationVector(motions[i].robot.linear() * motions[j].robot.linear().transpose());
      if (a.norm() > params.pair_angle_max_deg * kRadians) continue;
      scatter += a * a.transpose();
      ++count;
    }
  }
  if (count < 2) return 0.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter / count);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[1]));
}

std::vector<Chain> closedForms(const HandEyeProblem& problem, const std::vector<PosePair>& motions,
                               const Intrinsics& intrinsics, const HandEyeParams& params,
                               bool free_scale) {
  std::vector<Chain> chains;
  const auto add = [&](const Eigen::Isometry3d& T_mount_camera, double scale) {
    Chain chain;
    chain.mounting = problem.mounting;
    chain.intrinsics = intrinsics;
    chain.T_mount_camera = T_mount_camera;
    chain.scale = scale;
    chain.T_other_board = otherBoard(motions, T_mount_camera, scale);
    chains.push_back(chain);
  };
  if (params.four_axis) {
    // Of all heights that fit alike the one that is known.
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    const bool in_hand = problem.mounting == Mounting::kEyeInHand;
    if (motions.empty()) return chains;
    // The base's z axis in the mount's frame and in the board's other frame.
    const Eigen::Matrix3d& robot = motions.front().robot.linear();
    const Eigen::Vector3d up_mount = in_hand ? Eigen::Vector3d(robot * z) : z;
    const Eigen::Vector3d up_other = in_hand ? z : Eigen::Vector3d(robot.transpose() * z);
    const auto own = fromUprightPairs(motions, up_mount, free_scale);
    if (!own || !(std::abs(up_other.z()) > 0.5)) return chains;
    add(own->T_mount_camera, own->scale);
    Chain& chain = chains.back();
    const Eigen::Vector3d middle = 0.5 * problem.board.corner(problem.board.size() - 1);
    const double lacking = params.board_z - (chain.T_other_board * (chain.scale * middle)).z();
    chain.T_mount_camera.pretranslate(lacking / up_other.z() * up_mount);
    chain.T_other_board.pretranslate(lacking / up_other.z() * up_other);
    return chains;
  }
  if (const auto own = fromPairs(usefulPairs(motions, params), free_scale)) {
    add(own->T_mount_camera, own->scale);
  }
  if (free_scale) return chains;
  for (const auto method :
       {cv::CALIB_HAND_EYE_PARK, cv::CALIB_HAND_EYE_TSAI, cv::CALIB_HAND_EYE_HORAUD,
        cv::CALIB_HAND_EYE_ANDREFF, cv::CALIB_HAND_EYE_DANIILIDIS}) {
    if (const auto T = fromOpenCv(motions, method)) add(*T, 1.0);
  }
  return chains;
}

}  // namespace planar_bin_picking
