// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A robot, a camera and a checkerboard, with the truth: what the camera sees from each flange pose
/// and what the robot says of it. Drawn and projected without the code under test.

#include "plate_image.h"

#include "planar_bin_picking/base/se3.h"

#include <cmath>
#include <random>

namespace planar_bin_picking::sim {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

struct BoardCell {
  bool in_hand = true;
  PinholeCamera camera{
      2448, 2048, 3470.0, 3466.0, 1199.1, 1040.5, {-0.105, 0.065, -5e-4, 4e-4, 0.01}};
  int cols = 9, rows = 6;  // inner corners
  double square = 0.02;    // metres
  double marker = 0.0;     // metres
  /// Modules of the markers (0 dark) in the light squares, row by row; none: a plain checkerboard.
  std::vector<cv::Mat_<unsigned char>> markers{};
  Eigen::Isometry3d T_mount_camera = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_other_board = Eigen::Isometry3d::Identity();
  double corner_px = 0.05;                 // noise of a corner's coordinate
  double robot_mm = 0.0, robot_deg = 0.0;  // noise of a robot pose, per axis

  Eigen::Isometry3d cameraBoard(const Eigen::Isometry3d& T_base_flange) const {
    return T_mount_camera.inverse() * (in_hand ? T_base_flange.inverse() : T_base_flange) *
           T_other_board;
  }

  /// The flange pose that brings the board there.
  Eigen::Isometry3d flangeFor(const Eigen::Isometry3d& T_camera_board) const {
    if (in_hand) return T_other_board * T_camera_board.inverse() * T_mount_camera.inverse();
    return T_mount_camera * T_camera_board * T_other_board.inverse();
  }

  Eigen::Vector3d corner(int col, int row) const { return {square * col, square * row, 0.0}; }
  Eigen::Vector3d centre() const { return 0.5 * corner(cols - 1, rows - 1); }
};

/// A camera in the hand above a board on the table, or one over a robot that holds the board.
inline BoardCell makeCell(bool in_hand, std::mt19937* random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  BoardCell cell;
  cell.in_hand = in_hand;
  const auto turned = [](const Eigen::Vector3d& axis, double angle) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  if (in_hand) {
    cell.T_mount_camera = rigid(turned(Eigen::Vector3d::UnitZ(), 180.0 * kDegree * any(*random)) *
                                    turned(Eigen::Vector3d::UnitX(), 5.0 * kDegree * any(*random)),
                                {0.1 * any(*random), 0.1 * any(*random), 0.05});
    cell.T_other_board = rigid(turned(Eigen::Vector3d::UnitX(), 180.0 * kDegree) *
                                   turned(Eigen::Vector3d::UnitZ(), 180.0 * kDegree * any(*random)),
                               {0.5, 0.05 * any(*random), 0.02});
  } else {
    cell.T_mount_camera =
        rigid(turned(Eigen::Vector3d::UnitX(), 180.0 * kDegree) *
                  turned(Eigen::Vector3d::UnitZ(), 180.0 * kDegree * any(*random)),
              {0.6, 0.1 * any(*random), 1.2});
    cell.T_other_board = rigid(turned(Eigen::Vector3d::UnitZ(), 180.0 * kDegree * any(*random)) *
                                   turned(Eigen::Vector3d::UnitX(), 180.0 * kDegree),
                               {0.05 * any(*random), 0.05 * any(*random), 0.03});
  }
  return cell;
}

/// The board somewhere before the camera: turned about the optical axis, tilted by up to
/// `tilt_deg`, its centre at `distance` and within the given share of the image's half width and
/// height.
inline Eigen::Isometry3d randomView(const BoardCell& cell, double distance, double tilt_deg,
                                    double share, std::mt19937* random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const PinholeCamera& camera = cell.camera;
  const double axis = 180.0 * kDegree * any(*random);
  const double tilt = tilt_deg * kDegree * std::sqrt(std::abs(any(*random)));
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0.0)) *
       Eigen::AngleAxisd(180.0 * kDegree * any(*random), Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const double z = distance * (1.0 + 0.15 * any(*random));
  const Eigen::Vector3d centre(share * any(*random) * z * 0.5 * camera.width / camera.fx,
                               share * any(*random) * z * 0.5 * camera.height / camera.fy, z);
  return rigid(R, centre - R * cell.centre());
}

/// All corners as the camera sees them, with noise; false where one is outside the image.
inline bool seeCorners(const BoardCell& cell, const Eigen::Isometry3d& T_camera_board,
                       std::mt19937* random, std::vector<Eigen::Vector2d>* corners) {
  std::normal_distribution<double> noise(0.0, cell.corner_px);
  corners->clear();
  for (int row = 0; row < cell.rows; ++row) {
    for (int col = 0; col < cell.cols; ++col) {
      const Eigen::Vector3d p = T_camera_board * cell.corner(col, row);
      if (p.z() < 0.01) return false;
      const Eigen::Vector2d pixel = project(cell.camera, p);
      if (!(pixel.x() > 8 && pixel.x() < cell.camera.width - 9)) return false;
      if (!(pixel.y() > 8 && pixel.y() < cell.camera.height - 9)) return false;
      corners->push_back(pixel + Eigen::Vector2d(noise(*random), noise(*random)));
    }
  }
  return true;
}

/// Where the robot says it is when it is at T_base_flange.
inline Eigen::Isometry3d reported(const BoardCell& cell, const Eigen::Isometry3d& T_base_flange,
                                  std::mt19937* random) {
  std::normal_distribution<double> normal;
  Vector6d xi;
  for (int i = 0; i < 3; ++i) xi[i] = 1e-3 * cell.robot_mm * normal(*random);
  for (int i = 3; i < 6; ++i) xi[i] = kDegree * cell.robot_deg * normal(*random);
  return T_base_flange * exp(xi);
}

/// Squares from the first inner corner.
inline Ring rectangleOf(const BoardCell& cell, double x0, double y0, double x1, double y1) {
  const double s = 1e3 * cell.square;
  return {{s * x0, -s * y0}, {s * x0, -s * y1}, {s * x1, -s * y1}, {s * x1, -s * y0}};
}

inline void addMarkers(const BoardCell& cell, const Lying& board, Coverage* black,
                       Coverage* white) {
  const double rim = 0.5 * (1.0 - cell.marker / cell.square);
  std::size_t number = 0;
  for (int row = -1; row < cell.rows && !cell.markers.empty(); ++row) {
    for (int col = -1; col < cell.cols; ++col) {
      if ((row + col) % 2 == 0) continue;
      const cv::Mat_<unsigned char>& modules = cell.markers.at(number++);
      const double module = cell.marker / cell.square / modules.rows;
      const double left = col + rim, top = row + rim;
      addRing(cell.camera, board, rectangleOf(cell, left, top, col + 1 - rim, row + 1 - rim), 0.0,
              black);
      for (int v = 0; v < modules.rows; ++v) {
        for (int u = 0; u < modules.cols; ++u) {
          if (modules(v, u) == 0) continue;
          const double x = left + u * module, y = top + v * module;
          addRing(cell.camera, board, rectangleOf(cell, x, y, x + module, y + module), 0.0, white);
        }
      }
    }
  }
}

/// The picture of the board on a grey ground, 8 bit.
inline cv::Mat takeBoardImage(const BoardCell& cell, const Eigen::Isometry3d& T_camera_board,
                              double blur_px, double noise, int seed) {
  // Plates have y up and z toward the viewer; boards have y down and z away.
  Lying board;
  board.T_camera_part =
      T_camera_board * rigid(Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(), {0.0, 0.0, 0.0});
  const auto rectangle = [&cell](double x0, double y0, double x1, double y1) {
    return rectangleOf(cell, x0, y0, x1, y1);
  };
  cv::Mat_<float> image(cell.camera.height, cell.camera.width, 90.0F);
  Coverage paper(cell.camera.width, cell.camera.height), black = paper, white = paper;
  addRing(cell.camera, board, rectangle(-1.7, -1.7, cell.cols + 0.7, cell.rows + 0.7), 0.0, &paper);
  for (int row = -1; row < cell.rows; ++row) {
    for (int col = -1; col < cell.cols; ++col) {
      if ((row + col) % 2 != 0) continue;  // the square beyond the first corner is dark
      addRing(cell.camera, board, rectangle(col, row, col + 1, row + 1), 0.0, &black);
    }
  }
  addMarkers(cell, board, &black, &white);
  paper.paint(220.0, &image);
  black.paint(30.0, &image);
  white.paint(220.0, &image);
  if (blur_px > 0.0) cv::GaussianBlur(image, image, {}, blur_px);
  if (noise > 0.0) {
    cv::Mat_<float> grain(image.size());
    cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(grain, cv::RNG::NORMAL, 0.0, noise);
    image += grain;
  }
  cv::Mat out;
  image.convertTo(out, CV_8U);
  return out;
}

}  // namespace planar_bin_picking::sim
