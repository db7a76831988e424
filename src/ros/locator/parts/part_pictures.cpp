// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/parts/part_pictures.h"

#include "planar_bin_picking/show/part_picture.h"
#include "shared/names.h"

#include <cv_bridge/cv_bridge.h>
#include <ros/single_subscriber_publisher.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

#include <cstdio>

namespace planar_bin_picking_ros {

namespace {

constexpr double kLookSeconds = 0.5;

sensor_msgs::ImagePtr pictureOf(const planar_bin_picking::PartModel& part) {
  std_msgs::Header header;
  header.stamp = ros::Time::now();
  header.frame_id = part.name();
  return cv_bridge::CvImage(header, sensor_msgs::image_encodings::BGR8,
                            planar_bin_picking::drawPart(part))
      .toImageMsg();
}

bool isAllowed(const unsigned char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

}  // namespace

std::string pictureTopic(const std::string& part) {
  std::string topic = std::string(kPartPicturesTopic) + "/";
  for (const char c : part) {
    char code[8];
    std::snprintf(code, sizeof code, "_x%02x", static_cast<unsigned char>(c));
    topic += isAllowed(static_cast<unsigned char>(c)) ? std::string(1, c) : code;
  }
  return topic;
}

PartPictures::PartPictures(PartStore& store, const ros::NodeHandle& nh)
    : store_(store),
      nh_(nh),
      timer_(nh_.createWallTimer(ros::WallDuration(kLookSeconds),
                                 [this](const ros::WallTimerEvent&) { look(); })) {}

void PartPictures::look() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto library = store_.current();
  if (library == seen_) return;
  seen_ = library;
  for (auto topic = topics_.begin(); topic != topics_.end();) {
    topic = library->parts().count(topic->first) == 0 ? topics_.erase(topic) : std::next(topic);
  }
  for (const auto& [of_part, part] : library->parts()) {
    Topic& topic = topics_[of_part];
    if (!topic.publisher) {
      // Not latched by ROS, which would keep a picture of each. Without this object's mutex, since
      // a topic that goes waits for this.
      const auto draw = [this,
                         of_part = of_part](const ros::SingleSubscriberPublisher& subscriber) {
        const auto current = store_.current();
        const auto found = current->parts().find(of_part);
        if (found != current->parts().end()) subscriber.publish(pictureOf(*found->second));
      };
      const std::string name = pictureTopic(of_part);
      topic.publisher = nh_.advertise<sensor_msgs::Image>(name, 1, draw);
    } else if (topic.part != part && topic.publisher.getNumSubscribers() > 0) {
      topic.publisher.publish(pictureOf(*part));
    }
    topic.part = part;
  }
}

}  // namespace planar_bin_picking_ros
