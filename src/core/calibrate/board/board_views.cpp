// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/board/board_views.h"

#include "planar_bin_picking/base/se3.h"

#include <opencv2/calib3d.hpp>

namespace planar_bin_picking {
namespace {

std::vector<cv::Point3f> objectPoints(const SeenPoints& view) {
  std::vector<cv::Point3f> points;
  for (const Eigen::Vector3d& x : view.points) {
    points.emplace_back(static_cast<float>(x.x()), static_cast<float>(x.y()), 0.0F);
  }
  return points;
}

std::vector<cv::Point2f> imagePoints(const SeenPoints& view) {
  std::vector<cv::Point2f> points;
  for (const Eigen::Vector2d& p : view.corners) {
    points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return points;
}

struct CvCamera {
  cv::Mat_<double> K, distortion;
};

CvCamera toOpenCv(const Camera::Model& camera) {
  CvCamera out{cv::Mat_<double>::eye(3, 3), cv::Mat_<double>::zeros(1, 8)};
  out.K(0, 0) = camera.fx;
  out.K(1, 1) = camera.fy;
  out.K(0, 2) = camera.cx;
  out.K(1, 2) = camera.cy;
  for (std::size_t i = 0; i < camera.distortion.size() && i < 8; ++i) {
    out.distortion(static_cast<int>(i)) = camera.distortion[i];
  }
  return out;
}

Eigen::Isometry3d fromOpenCv(const cv::Mat_<double>& rvec, const cv::Mat_<double>& tvec) {
  const Eigen::Vector3d w(rvec(0), rvec(1), rvec(2));
  const double angle = w.norm();
  const Eigen::Vector3d axis = angle > 0.0 ? Eigen::Vector3d(w / angle) : Eigen::Vector3d::UnitZ();
  return rigid(Eigen::AngleAxisd(angle, axis).toRotationMatrix(),
               Eigen::Vector3d(tvec(0), tvec(1), tvec(2)));
}

}  // namespace

Camera::Model cameraFromBoards(const std::vector<SeenPoints>& views, int width, int height) {
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> images;
  for (const SeenPoints& view : views) {
    objects.push_back(objectPoints(view));
    images.push_back(imagePoints(view));
  }
  const cv::Size size(width, height);
  cv::Mat_<double> K = cv::initCameraMatrix2D(objects, images, size, 1.0);
  // Views that hardly tilt say nothing of the focal length: start with a usual lens then.
  const double usual = 1.2 * width;
  if (!(K(0, 0) > 0.2 * width && K(0, 0) < 20.0 * width)) {
    K = (cv::Mat_<double>(3, 3) << usual, 0, 0.5 * (width - 1), 0, usual, 0.5 * (height - 1), 0, 0,
         1);
  }
  cv::Mat_<double> distortion = cv::Mat_<double>::zeros(1, 5);
  std::vector<cv::Mat> rotations, translations;
  const int flags = cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_ASPECT_RATIO |
                    cv::CALIB_FIX_PRINCIPAL_POINT | cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K2 |
                    cv::CALIB_FIX_K3;
  cv::calibrateCamera(objects, images, size, K, distortion, rotations, translations, flags);
  return {width,   height,  K(0, 0),     K(1, 1),
          K(0, 2), K(1, 2), "plumb_bob", {distortion(0), 0.0, 0.0, 0.0, 0.0}};
}

std::optional<Eigen::Isometry3d> boardPose(const Camera::Model& camera, const SeenPoints& view) {
  const CvCamera cv_camera = toOpenCv(camera);
  cv::Mat_<double> rvec, tvec;
  const bool solved = cv::solvePnP(objectPoints(view), imagePoints(view), cv_camera.K,
                                   cv_camera.distortion, rvec, tvec, false, cv::SOLVEPNP_IPPE);
  if (!solved || !cv::checkRange(rvec) || !cv::checkRange(tvec)) return std::nullopt;
  return boardPoseNear(camera, view, fromOpenCv(rvec, tvec));
}

Eigen::Isometry3d boardPoseNear(const Camera::Model& camera, const SeenPoints& view,
                                const Eigen::Isometry3d& T_camera_board) {
  const CvCamera cv_camera = toOpenCv(camera);
  const Eigen::Vector3d w = rotationVector(T_camera_board.linear()),
                        t = T_camera_board.translation();
  cv::Mat_<double> rvec = (cv::Mat_<double>(3, 1) << w.x(), w.y(), w.z());
  cv::Mat_<double> tvec = (cv::Mat_<double>(3, 1) << t.x(), t.y(), t.z());
  cv::solvePnP(objectPoints(view), imagePoints(view), cv_camera.K, cv_camera.distortion, rvec, tvec,
               true, cv::SOLVEPNP_ITERATIVE);
  return fromOpenCv(rvec, tvec);
}

}  // namespace planar_bin_picking
