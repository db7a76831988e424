// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/answer_publisher.h"

#include "locator/answer/display.h"
#include "planar_bin_picking/show/overlay.h"
#include "shared/convert.h"
#include "shared/names.h"

#include <cv_bridge/cv_bridge.h>
#include <planar_bin_picking/LocatedParts.h>
#include <ros/callback_queue_interface.h>
#include <ros/master.h>
#include <ros/this_node.h>
#include <sensor_msgs/image_encodings.h>
#include <boost/make_shared.hpp>

#include <algorithm>
#include <cstdint>

namespace planar_bin_picking_ros {

using planar_bin_picking::LocatedPart;
using planar_bin_picking::LocatedParts;

class AnswerPublisher::Draw : public ros::CallbackInterface {
 public:
  explicit Draw(AnswerPublisher* publisher) : publisher_(publisher) {}
  CallResult call() override {
    const image_transport::Publisher& overlay = publisher_->overlay_;
    if (overlay.getNumSubscribers() > 0) overlay.publish(publisher_->overlayOfLatest());
    return Success;
  }

 private:
  AnswerPublisher* publisher_;
};

namespace {

/// Not below the node's name, where launch files clear parameters before a node starts.
std::string rememberedKey(std::string node) {
  for (std::size_t at; (at = node.find('/')) != std::string::npos;) node.replace(at, 1, "__");
  return kPublishedFramesParam + node;
}

std::vector<std::string> namesOf(const std::vector<planar_bin_picking::PartPtr>& parts) {
  std::vector<std::string> names;
  for (const auto& part : parts) names.push_back(part->name());
  return names;
}

planar_bin_picking::OverlayMore overlayMore(const Answer& answer) {
  planar_bin_picking::OverlayMore more;
  for (std::size_t i = 0; i < answer.refused.size(); ++i)
    more.refused.push_back({answer.refused_detections[i], nameOfReason(answer.refused[i].reason)});
  for (const auto& located : answer.located)
    for (const auto& pick : located.picks)
      more.T_camera_pick.push_back(answer.T_target_camera.inverse() * fromMsg(pick.pose));
  more.outlines = answer.outlines;
  more.has_legend = true;
  return more;
}

bool isOneOf(const LocatedPart& located, const std::vector<planar_bin_picking::PartPtr>& parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const auto& part) { return part->name() == located.part; });
}

template <class Test>
void dropIf(std::vector<LocatedPart>* parts, Test&& test) {
  parts->erase(std::remove_if(parts->begin(), parts->end(), test), parts->end());
}

}  // namespace

AnswerPublisher::AnswerPublisher(const ros::NodeHandle& pnh, const ros::NodeHandle& prompt_nh,
                                 const std::string& frame_prefix)
    : pnh_(pnh),
      images_(pnh),
      frames_(frame_prefix.empty() ? defaultFramePrefix(pnh.getNamespace()) : frame_prefix),
      remembered_key_(rememberedKey(pnh.getNamespace())) {
  std::vector<std::string> former;
  if (pnh_.getParam(remembered_key_, former)) frames_.withdrawFrames(former);
  remembered_ = frames_.names().size();
  timer_ = prompt_nh.createWallTimer(ros::WallDuration(1.0 / kFrameRate),
                                     [this](const ros::WallTimerEvent&) {
                                       const std::lock_guard<std::mutex> lock(mutex_);
                                       sendFrames();
                                     });
  constexpr bool kLatch = true;
  list_ = pnh_.advertise<LocatedParts>(kLocatedPartsTopic, 1, kLatch);
  markers_ = pnh_.advertise<visualization_msgs::MarkerArray>(kMarkersTopic, 1, kLatch);
  // Not latched by ROS, which would hand out the last picture drawn, not that of the last answer.
  overlay_ = images_.advertise(
      kOverlayTopic, 1, [this](const image_transport::SingleSubscriberPublisher& subscriber) {
        if (const auto picture = overlayOfLatest()) subscriber.publish(*picture);
      });
}

AnswerPublisher::~AnswerPublisher() {
  timer_.stop();
  pnh_.getCallbackQueue()->removeByID(reinterpret_cast<std::uintptr_t>(this));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    frames_.withdrawAll();
    sendFrames();
  }
  // roscpp sends from a thread of its own and drops what is left when the publisher goes.
  ros::WallDuration(0.2).sleep();
}

void AnswerPublisher::sendFrames(PartFrames::Transforms transforms) {
  if (clock_.wentBack()) frames_.forgetTimes();
  const auto due = frames_.at(ros::Time::now());
  transforms.insert(transforms.end(), due.begin(), due.end());
  if (!transforms.empty()) tf_.sendTransform(transforms);
}

void AnswerPublisher::remember() {
  const std::vector<std::string> names = frames_.names();
  if (names.size() == remembered_) return;
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  request[1] = remembered_key_;
  for (std::size_t i = 0; i < names.size(); ++i) request[2][static_cast<int>(i)] = names[i];
  // ros::param::set would wait for a master that is gone, and the caller with it.
  constexpr bool kWaitForMaster = false;
  if (ros::master::execute("setParam", request, response, payload, kWaitForMaster))
    remembered_ = names.size();
}

void AnswerPublisher::withdraw(const std::vector<planar_bin_picking::PartPtr>& parts) {
  const std::lock_guard<std::mutex> lock(mutex_);
  frames_.withdraw(namesOf(parts));
  dropIf(&listed_, [&](const LocatedPart& part) { return isOneOf(part, parts); });
  sendFrames();
}

void AnswerPublisher::clearMarkers() { markers_.publish(makeMarkers({})); }

void AnswerPublisher::withdrawBefore(const Answer& answer) {
  if (!answer.former) {
    frames_.withdraw(namesOf(answer.parts));
    listed_.clear();
    listed_kinds_.clear();
    return;
  }
  std::vector<std::string> frames;
  for (const FormerPart& former : *answer.former)
    if (!former.child_frame.empty()) frames.push_back(former.child_frame);
  frames_.withdrawLocated(frames);
  dropIf(&listed_, [&](const LocatedPart& part) {
    return std::find(frames.begin(), frames.end(), part.child_frame) != frames.end();
  });
}

std::shared_ptr<const Answer> AnswerPublisher::publish(Answer answer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  withdrawBefore(answer);  // another caller's answer may have come in between, too
  frames_.name(answer.located);
  auto transforms = frames_.show(answer.header, answer.located);
  remember();  // before they are sent: this process may end at any time
  sendFrames(std::move(transforms));

  LocatedParts list;
  list.header = answer.header;
  list.parts = answer.located;
  list.parts.insert(list.parts.end(), listed_.begin(), listed_.end());
  listed_ = list.parts;
  for (const auto& part : answer.parts)
    if (std::find(listed_kinds_.begin(), listed_kinds_.end(), part) == listed_kinds_.end())
      listed_kinds_.insert(listed_kinds_.begin(), part);
  list_.publish(list);
  markers_.publish(makeMarkers({answer.header, listed_, answer.refused, listed_kinds_,
                                answer.tool_radius, answer.tool_bodies}));

  latest_ = std::make_shared<const Answer>(std::move(answer));
  pnh_.getCallbackQueue()->addCallback(boost::make_shared<Draw>(this),
                                       reinterpret_cast<std::uintptr_t>(this));
  return latest_;
}

sensor_msgs::ImageConstPtr AnswerPublisher::overlayOfLatest() {
  const std::lock_guard<std::mutex> overlay_lock(overlay_mutex_);
  std::shared_ptr<const Answer> latest;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    latest = latest_;
  }
  if (latest == drawn_) return picture_;
  const cv::Mat picture = planar_bin_picking::drawOverlay(
      latest->grey, latest->camera, latest->parts, latest->result.detections, overlayMore(*latest));
  picture_ =
      cv_bridge::CvImage(latest->frame.image->header, sensor_msgs::image_encodings::BGR8, picture)
          .toImageMsg();
  drawn_ = latest;
  return picture_;
}

}  // namespace planar_bin_picking_ros
