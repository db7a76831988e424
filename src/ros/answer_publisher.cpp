// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "answer_publisher.h"

#include "display.h"
#include "names.h"
#include "planar_bin_picking/overlay.h"

#include <cv_bridge/cv_bridge.h>
#include <planar_bin_picking/LocatedParts.h>
#include <ros/callback_queue_interface.h>
#include <sensor_msgs/image_encodings.h>
#include <boost/make_shared.hpp>

#include <cstdint>

namespace planar_bin_picking_ros {

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

AnswerPublisher::AnswerPublisher(const ros::NodeHandle& pnh, const std::string& frame_prefix)
    : pnh_(pnh), images_(pnh), frames_(frame_prefix) {
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
  pnh_.getCallbackQueue()->removeByID(reinterpret_cast<std::uintptr_t>(this));
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
  const cv::Mat picture = planar_bin_picking::drawOverlay(latest->grey, latest->camera,
                                                          latest->parts, latest->result.detections);
  picture_ =
      cv_bridge::CvImage(latest->frame.image->header, sensor_msgs::image_encodings::BGR8, picture)
          .toImageMsg();
  drawn_ = latest;
  return picture_;
}

}  // namespace planar_bin_picking_ros
