// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "input/image_inbox.h"

namespace planar_bin_picking_ros {

void ImageInbox::push(const sensor_msgs::ImageConstPtr& image,
                      const sensor_msgs::CameraInfoConstPtr& info) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    newest_ = Frame{image, info, std::chrono::steady_clock::now(), ros::Time::now()};
    ++count_;
  }
  arrived_.notify_all();
}

std::optional<Frame> ImageInbox::wait(const FrameWish& wish, const SteadyTime deadline) {
  const auto fits = [&] {
    return newest_ && newest_->image->header.stamp >= wish.not_before &&
           newest_->received > wish.received_after && newest_->clock >= wish.clock_from;
  };
  std::unique_lock<std::mutex> lock(mutex_);
  arrived_.wait_until(lock, deadline, [&] { return closed_ || fits(); });
  if (closed_ || !fits()) return std::nullopt;
  return newest_;
}

std::size_t ImageInbox::count() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return count_;
}

std::optional<Frame> ImageInbox::newest() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_;
}

void ImageInbox::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_.reset();
}

bool ImageInbox::closed() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return closed_;
}

void ImageInbox::close() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
  }
  arrived_.notify_all();
}

void ImageInbox::open() {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = false;
}

}  // namespace planar_bin_picking_ros
