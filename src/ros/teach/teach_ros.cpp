// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "teach/teach_ros.h"

#include "planar_bin_picking/teach/snap.h"
#include "shared/convert.h"
#include "shared/names.h"
#include "teach/teach_markers.h"

#include <ros/console.h>
#include <std_msgs/String.h>

#include <map>
#include <optional>
#include <stdexcept>

namespace planar_bin_picking_ros {

using planar_bin_picking::Face;
using planar_bin_picking::PickPose;
using visualization_msgs::InteractiveMarkerFeedback;

namespace {

constexpr double kQuarter = EIGEN_PI / 2.0;
constexpr double kStill = 1e-5;  // share by which rviz, which has fewer digits, changes a pose

std::string requiredParam(const ros::NodeHandle& pnh, const std::string& key,
                          const std::string& what) {
  std::string value;
  if (!pnh.getParam(key, value) || value.empty())
    throw std::invalid_argument("~" + key + " is not set: " + what);
  return value;
}

/// Runs it for its message; what it refuses is an answer, too.
template <class Act, class Response>
void answer(Act&& act, Response* response) {
  try {
    response->message = act();
    response->success = true;
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(error.what());
    response->message = error.what();
    response->success = false;
  }
}

}  // namespace

TeachRos::TeachRos(const ros::NodeHandle&, const ros::NodeHandle& pnh)
    : taught_(planar_bin_picking::findPart(
          requiredParam(pnh, "part", "the name of a part, or the path of its file"),
          requiredParam(pnh, "parts_folder", "the folder of the parts"))),
      server_(pnh.resolveName(kTeachMarkersTopic)) {
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = ros::Time::now();
  transform.header.frame_id = kTeachFrame;
  transform.child_frame_id = kTaughtFrame;
  transform.transform.rotation.w = 1.0;
  tf_.sendTransform(transform);
  constexpr bool kLatch = true;
  ros::NodeHandle handle = pnh;
  status_ = handle.advertise<std_msgs::String>(kStatusTopic, 1, kLatch);
  save_ = handle.advertiseService(kSaveService, &TeachRos::serveSave, this);
  rename_ = handle.advertiseService(kRenameService, &TeachRos::serveRename, this);
  const planar_bin_picking::PartModel& part = taught_.part();  // for rviz_cell.py: what to look at
  handle.setParam(
      "view", std::map<std::string, double>{
                  {"x", part.center().x()}, {"y", part.center().y()}, {"radius", part.radius()}});
  addPartMenu();
  addPoseMenu();
  show("right-click the part to add a pick pose, a pick pose to change it");
}

TeachRos::~TeachRos() {
  if (taught_.isChanged()) ROS_WARN("the node ends, and what was changed last is not saved");
}

void TeachRos::addPartMenu() {
  for (const Face face : {Face::kFront, Face::kBack}) {
    const std::string word = face == Face::kFront ? "front" : "back";
    part_menu_.insert("add a pick pose here, " + word, entry([this, face](const auto& feedback) {
                        std::optional<Eigen::Vector2d> at;
                        if (feedback.mouse_point_valid)
                          at = Eigen::Vector2d(feedback.mouse_point.x, feedback.mouse_point.y);
                        return taught_.add(face, at) + " is new";
                      }));
  }
  part_menu_.insert("save", entry([this](const auto&) { return taught_.save(); }));
  part_menu_.insert("forget the changes, read the file anew", entry([this](const auto&) {
                      taught_.readAnew();
                      return std::string("the file's pick poses");
                    }));
}

void TeachRos::addMove(const std::string& title,
                       const std::function<PickPose(const PickPose&)>& move) {
  pose_menu_.insert(title, entry([this, title, move](const auto& feedback) {
                      taught_.change(move(taught_.pose(feedback.marker_name)));
                      return feedback.marker_name + ": " + title;
                    }));
}

void TeachRos::addPoseMenu() {
  const auto drawing = [this]() -> const auto& { return taught_.part().file().drawing; };
  addMove("snap to the face's normal",
          [this](const auto& pose) { return snappedToNormal(pose, taught_.part().thickness()); });
  addMove("snap to the centroid",
          [drawing](const auto& pose) { return snappedToCentroid(pose, drawing()); });
  addMove("snap to the nearest hole", [drawing](const auto& pose) {
    const auto snapped = snappedToHole(pose, drawing());
    if (!snapped) throw std::runtime_error("the part has no hole");
    return *snapped;
  });
  addMove("turn by 90 degrees", [](const auto& pose) { return turned(pose, kQuarter); });
  addMove("to the other face",
          [this](const auto& pose) { return forOtherFace(pose, taught_.part().thickness()); });
  pose_menu_.insert("earlier: the robot prefers it", entry([this](const auto& feedback) {
                      taught_.prefer(feedback.marker_name);
                      std::string order;
                      for (const PickPose& pose : taught_.poses())
                        order += (order.empty() ? "" : ", ") + pose.name;
                      return "the order is " + order;
                    }));
  pose_menu_.insert("rename", entry([this](const auto& feedback) {
                      return "in a terminal: rosservice call " + rename_.getService() +
                             " \"{name: " + feedback.marker_name + ", new_name: NEW}\"";
                    }));
  pose_menu_.insert("delete", entry([this](const auto& feedback) {
                      taught_.remove(feedback.marker_name);
                      return feedback.marker_name + " is deleted";
                    }));
  pose_menu_.insert("save", entry([this](const auto&) { return taught_.save(); }));
}

interactive_markers::MenuHandler::FeedbackCallback TeachRos::entry(
    const std::function<std::string(const InteractiveMarkerFeedback&)>& act) {
  return [this, act](const Feedback& feedback) {
    try {
      show(act(*feedback));
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM(error.what());
      show(error.what());
    }
  };
}

void TeachRos::moved(const Feedback& feedback) {
  const bool is_drag = feedback->event_type == InteractiveMarkerFeedback::POSE_UPDATE;
  const bool is_end = feedback->event_type == InteractiveMarkerFeedback::MOUSE_UP;
  if (!is_drag && !is_end) return;
  try {
    PickPose pose = taught_.pose(feedback->marker_name);
    const Eigen::Isometry3d T_part_pick = fromMsg(feedback->pose);
    if (feedback->header.frame_id != kTaughtFrame || !T_part_pick.matrix().allFinite())
      throw std::runtime_error("a move of " + pose.name + " is not in the frame " + kTaughtFrame);
    // A click alone is no move, though rviz sends the pose as long as the button is down.
    is_dragged_ = is_dragged_ || !pose.T_part_pick.isApprox(T_part_pick, kStill);
    if (!is_dragged_) return;
    is_dragged_ = is_drag;
    pose.T_part_pick = T_part_pick;
    taught_.change(pose);
    // A marker that is sent anew would be taken out of the hand that drags it.
    if (is_end) show(pose.name + " is moved");
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(error.what());
    show(error.what());
  }
}

bool TeachRos::serveSave(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  answer([this] { return taught_.save(); }, &response);
  show(response.message);
  return true;
}

bool TeachRos::serveRename(planar_bin_picking::RenamePick::Request& request,
                           planar_bin_picking::RenamePick::Response& response) {
  const auto rename = [&] {
    taught_.rename(request.name, request.new_name);
    return request.name + " is called " + request.new_name + " now";
  };
  answer(rename, &response);
  show(response.message);
  return true;
}

void TeachRos::show(const std::string& news) {
  std::set<std::string> now;
  for (const PickPose& pose : taught_.poses()) {
    server_.insert(poseMarker(taught_, pose),
                   [this](const Feedback& feedback) { moved(feedback); });
    pose_menu_.apply(server_, pose.name);
    now.insert(pose.name);
  }
  for (const std::string& name : shown_)
    if (now.count(name) == 0) server_.erase(name);
  shown_ = now;
  server_.insert(partMarker(taught_, news));
  part_menu_.apply(server_, kPartMarker);
  server_.applyChanges();
  std_msgs::String status;
  status.data = news;
  status_.publish(status);
}

}  // namespace planar_bin_picking_ros
