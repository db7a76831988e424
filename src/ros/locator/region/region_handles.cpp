// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/region/region_handles.h"

#include "shared/convert.h"
#include "shared/marker_values.h"
#include "shared/names.h"

#include <ros/callback_queue_interface.h>
#include <ros/console.h>
#include <visualization_msgs/InteractiveMarker.h>
#include <boost/make_shared.hpp>

#include <cstdint>
#include <exception>
#include <utility>

namespace planar_bin_picking_ros {

using visualization_msgs::InteractiveMarker;
using visualization_msgs::InteractiveMarkerControl;
using visualization_msgs::InteractiveMarkerFeedback;
using visualization_msgs::Marker;

namespace {

class Posted : public ros::CallbackInterface {
 public:
  explicit Posted(std::function<void()> act) : act_(std::move(act)) {}
  CallResult call() override {
    try {
      act_();
    } catch (const std::exception& error) {  // nothing that rviz sends may end the node
      ROS_ERROR_STREAM("region: " << error.what());
    }
    return Success;
  }

 private:
  std::function<void()> act_;
};

constexpr char kCorner[] = "corner ";
constexpr bool kThread = true;  // of its own: a nodelet's queues are not the global one
constexpr double kBall = 0.02, kAbove = 0.002;  // metres

InteractiveMarker handleOf(const std::string& frame, const std::size_t corner,
                           const Eigen::Isometry3d& T_frame_corner) {
  InteractiveMarker handle;
  handle.header.frame_id = frame;
  handle.name = kCorner + std::to_string(corner + 1);
  handle.description = "";
  handle.scale = static_cast<float>(2.0 * kBall);
  handle.pose = toPoseMsg(T_frame_corner);
  InteractiveMarkerControl drag;
  drag.name = "drag";
  drag.interaction_mode = InteractiveMarkerControl::MOVE_PLANE;
  drag.always_visible = true;
  drag.orientation = toPoseMsg(Eigen::Isometry3d(Eigen::Quaterniond::FromTwoVectors(
                                   Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ())))
                         .orientation;  // the plane is across its x
  Marker ball;
  ball.type = Marker::SPHERE;
  ball.pose.orientation.w = 1.0;
  ball.scale.x = ball.scale.y = ball.scale.z = kBall;
  ball.color = colorOf(1.0f, 1.0f, 0.2f);
  drag.markers.push_back(ball);
  handle.controls.push_back(drag);
  return handle;
}

}  // namespace

RegionHandles::RegionHandles(const ros::NodeHandle& pnh, std::string frame, Actions actions)
    : pnh_(pnh),
      frame_(std::move(frame)),
      actions_(std::move(actions)),
      server_(std::make_unique<interactive_markers::InteractiveMarkerServer>(
          pnh_.resolveName(kRegionHandlesTopic), "", kThread)) {
  const auto entry = [this](const std::function<void(std::size_t)>& act) {
    return [this, act](const Feedback& feedback) { onCorner(feedback, act); };
  };
  menu_.insert("a corner more, behind this one", entry(actions_.insert));
  menu_.insert("delete this corner", entry(actions_.remove));
  menu_.insert("save: put the region in force and keep it",
               entry([this](std::size_t) { actions_.save(); }));
  menu_.insert("forget the changes", entry([this](std::size_t) { actions_.clear(); }));
}

RegionHandles::~RegionHandles() {
  server_.reset();  // from here on nobody posts anything
  pnh_.getCallbackQueue()->removeByID(reinterpret_cast<std::uintptr_t>(this));
}

void RegionHandles::post(std::function<void()> act) {
  pnh_.getCallbackQueue()->addCallback(boost::make_shared<Posted>(std::move(act)),
                                       reinterpret_cast<std::uintptr_t>(this));
}

void RegionHandles::onCorner(const Feedback& feedback,
                             const std::function<void(std::size_t)>& act) {
  const std::string& name = feedback->marker_name;
  const std::string number = name.compare(0, sizeof kCorner - 1, kCorner) == 0
                                 ? name.substr(sizeof kCorner - 1)
                                 : std::string();
  if (number.empty() || number.size() > 4 ||
      number.find_first_not_of("0123456789") != std::string::npos)
    return;
  const std::size_t corner = std::stoul(number) - 1;
  post([corner, act] { act(corner); });
}

void RegionHandles::moved(const Feedback& feedback) {
  const bool is_end = feedback->event_type == InteractiveMarkerFeedback::MOUSE_UP;
  if (!is_end && feedback->event_type != InteractiveMarkerFeedback::POSE_UPDATE) return;
  const auto& p = feedback->pose.position;
  const Eigen::Vector3d p_frame(p.x, p.y, p.z);
  if (feedback->header.frame_id != frame_ || !p_frame.allFinite()) return;
  onCorner(feedback, [this, p_frame, is_end](const std::size_t corner) {
    actions_.move(corner, p_frame, is_end);
  });
}

void RegionHandles::show(const planar_bin_picking::RegionOutline& corners,
                         const Eigen::Isometry3d& T_frame_region) {
  server_->clear();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Translation3d place(corners[i].x(), corners[i].y(), kAbove);
    const InteractiveMarker handle = handleOf(frame_, i, T_frame_region * place);
    server_->insert(handle, [this](const Feedback& feedback) { moved(feedback); });
    menu_.apply(*server_, handle.name);
  }
  server_->applyChanges();
}

}  // namespace planar_bin_picking_ros
