// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "locator/pick_keeper.h"

#include "shared/convert.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;
using planar_bin_picking::PartModel;
using planar_bin_picking::PickBin;
using planar_bin_picking::PickParams;
using planar_bin_picking::RefusedPart;
using Request = planar_bin_picking::ReportPick::Request;
using Response = planar_bin_picking::ReportPick::Response;

/// Camera and target frame alike: z down. Parts lie 0.8 m below, front up.
inline Eigen::Isometry3d lying(double x, double y) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, 0.8);
  T.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return T;
}

inline std::shared_ptr<const PartModel> load(const std::string& name) {
  return std::make_shared<const PartModel>(planar_bin_picking::loadPartFile(
      std::string(PACKAGE_DIR) + "/test/data/parts/" + name + ".yaml"));
}

inline Detection detectionAt(const Eigen::Isometry3d& T_camera_part, const std::string& name) {
  Detection detection;
  detection.T_camera_part = T_camera_part;
  detection.score = 0.9;
  detection.evidence.edges = 0.9;
  detection.visible_fraction = 1.0;
  detection.part_name = name;
  return detection;
}

inline Answer answerWith(const std::vector<Eigen::Isometry3d>& poses, double stamp, int grey = 90,
                         const std::string& name = "hinge") {
  planar_bin_picking::Camera::Model model;
  model.width = 1280, model.height = 1024, model.fx = model.fy = 1500.0, model.cx = 640.0,
  model.cy = 512.0;
  Answer answer{{load(name)},
                {},
                cv::Mat(1024, 1280, CV_8U, cv::Scalar(grey)),
                planar_bin_picking::Camera(model),
                {},
                {},
                {}};
  answer.frame.received = std::chrono::steady_clock::now();
  answer.header.stamp = ros::Time(stamp);
  answer.header.frame_id = "camera";
  for (const auto& T : poses) answer.result.detections.push_back(detectionAt(T, name));
  return answer;
}

/// What went out: the answer and what was said of it.
struct Sent {
  Answer answer;
  PickKeeper::Offered offered;
};

/// Offers the answer, its frames named as the publisher would name them.
inline Sent offer(PickKeeper* keeper, const Answer& answer, const PickKeeper::Frames& frames = {},
                  const PickKeeper::Call& call = {"/robot", 0}) {
  Sent sent{answer, {}};
  sent.offered = keeper->offer(answer, frames, call, [&](Answer out) {
    for (std::size_t i = 0; i < out.located.size(); ++i)
      out.located[i].child_frame = out.located[i].part + "_" + std::to_string(i + 1);
    sent.answer = out;
    return out.located;
  });
  EXPECT_EQ(sent.answer.located.size(), sent.answer.result.detections.size());
  return sent;
}

inline Response report(PickKeeper* keeper, double stamp, const std::string& frame, bool success,
                       const std::string& caller = "/robot") {
  Request request;
  request.stamp = ros::Time(stamp);
  request.child_frame = frame;
  request.success = success;
  Response response;
  keeper->report(caller, request, &response);
  return response;
}

/// The bin's z is up, the camera's down.
inline PickKeeper::Frames binUpTo(double x_max) {
  PickKeeper::Frames frames;
  frames.bin = PickBin();
  frames.bin->min = Eigen::Vector3d(-0.2, -0.2, -0.81);
  frames.bin->max = Eigen::Vector3d(x_max, 0.2, -0.7);
  frames.bin->T_bin_target.linear() =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return frames;
}

}  // namespace planar_bin_picking_ros
