// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "answer_publisher.h"

#include "display.h"
#include "names.h"
#include "planar_bin_picking/overlay.h"

#include <planar_bin_picking/LocatedParts.h>
#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

namespace planar_bin_picking_ros {

using planar_bin_picking::LocatedParts;

AnswerPublisher::AnswerPublisher(const ros::NodeHandle& pnh, const std::string& frame_prefix)
    : pnh_(pnh), images_(pnh), frames_(frame_prefix) {
  constexpr bool kLatch = true;
  list_ = pnh_.advertise<LocatedParts>(kLocatedPartsTopic, 1, kLatch);
  markers_ = pnh_.advertise<visualization_msgs::MarkerArray>(kMarkersTopic, 1, kLatch);
  // Not latched by ROS, which would hand out the last picture drawn, not that of the last answer.
  overlay_ = images_.advertise(
      kOverlayTopic, 1,
      [this](const image_transport::SingleSubscriberPublisher& subscriber) { showLatest(subscriber); });
}

std::shared_ptr<const Answer> AnswerPublisher::publish(Answer answer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  frames_.name(answer.located);
  std::vector<std::string> asked_for;
  for (const PartPtr& part : answer.parts) asked_for.push_back(part->name());
  tf_.sendTransform(frames_.update(asked_for, answer.header, answer.located));

  LocatedParts list;
  list.header = answer.header;
  list.parts = answer.located;
  list_.publish(list);
  markers_.publish(makeMarkers(answer.header, answer.located, answer.parts));

  latest_ = std::make_shared<const Answer>(std::move(answer));
  latest_overlay_.reset();
  if (overlay_.getNumSubscribers() > 0) overlay_.publish(overlayOfLatest());
  return latest_;
}

void AnswerPublisher::showLatest(const image_transport::SingleSubscriberPublisher& subscriber) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (latest_) subscriber.publish(overlayOfLatest());
}

sensor_msgs::ImageConstPtr AnswerPublisher::overlayOfLatest() {
  if (!latest_overlay_) {
    const cv::Mat picture = planar_bin_picking::drawOverlay(
        latest_->grey, latest_->camera, latest_->parts, latest_->result.detections);
    latest_overlay_ = cv_bridge::CvImage(latest_->frame.image->header,
                                         sensor_msgs::image_encodings::BGR8, picture)
                          .toImageMsg();
  }
  return latest_overlay_;
}

}  // namespace planar_bin_picking_ros
