// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A service call that can be waited for and broken off: roscpp's own waits for ever. It runs in a
/// thread that shares nothing with its caller but the call's own state, and whoever breaks it off
/// knows that its request is not sent any more.

#include <ros/connection.h>
#include <ros/serialization.h>
#include <ros/service_manager.h>
#include <ros/service_server_link.h>
#include <ros/service_traits.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace planar_bin_picking_ros {

enum class CallEnd {
  kAnswered,
  kNobody,  ///< no node offers the service
  kFailed,  ///< the other node went away or reported an error
  kLate,    ///< no answer in time; the call was broken off
};

/// A connection to a service. Made beforehand it needs no ROS master when it counts.
/// @return  null where nobody offers the service
template <class Service>
ros::ServiceServerLinkPtr connectService(const std::string& name) {
  const std::string md5 = ros::service_traits::md5sum<Service>();
  constexpr bool kPersistent = true;  // it is ours to drop
  return ros::ServiceManager::instance()->createServiceServerLink(name, kPersistent, md5, md5, {});
}

inline void dropService(const ros::ServiceServerLinkPtr& link) {
  if (link) link->getConnection()->drop(ros::Connection::Destructing);
}

template <class Service>
class ServiceCall {
 public:
  /// Begins the call.
  /// @param name  resolved
  /// @param link  a connection that stands already; null = one is made
  ServiceCall(const std::string& name, const typename Service::Request& request,
              const ros::ServiceServerLinkPtr& link = nullptr)
      : state_(std::make_shared<State>()) {
    state_->request = request;
    state_->link = link;
    thread_ = std::thread(&ServiceCall::run, state_, name);
  }

  ~ServiceCall() {
    breakOff();
    // Only a ROS master that hangs while it is asked keeps the thread; it holds its own state.
    if (waitUntil(std::chrono::steady_clock::now() + std::chrono::seconds(1))) {
      thread_.join();
    } else {
      thread_.detach();
    }
  }
  ServiceCall(const ServiceCall&) = delete;
  ServiceCall& operator=(const ServiceCall&) = delete;

  /// @return  whether the call is over
  bool waitUntil(std::chrono::steady_clock::time_point deadline) {
    std::unique_lock<std::mutex> lock(state_->mutex);
    return state_->over.wait_until(lock, deadline, [this] { return state_->is_over; });
  }

  /// Ends the call, and with it the connection. Nothing is sent afterwards.
  void breakOff() {
    ros::ServiceServerLinkPtr link;
    {
      const std::lock_guard<std::mutex> lock(state_->mutex);
      if (state_->is_over) return;
      state_->is_broken_off = true;
      link = state_->link;
    }
    dropService(link);
  }

  /// @pre waitUntil() said that it is over
  CallEnd end() const { return state_->end; }
  const typename Service::Response& response() const { return state_->response; }

 private:
  struct State {
    std::mutex mutex;
    std::condition_variable over;
    bool is_over = false, is_broken_off = false;
    CallEnd end = CallEnd::kFailed;
    ros::ServiceServerLinkPtr link;
    typename Service::Request request;
    typename Service::Response response;
  };

  static void run(const std::shared_ptr<State>& state, const std::string& name) {
    const bool is_own = !state->link || !state->link->isValid();
    const ros::ServiceServerLinkPtr link = is_own ? connectService<Service>(name) : state->link;
    bool is_wanted = true;
    {
      const std::lock_guard<std::mutex> lock(state->mutex);
      state->link = link;
      is_wanted = !state->is_broken_off;
    }
    // Broken off later than this, the connection is dropped, and call() sends nothing over it.
    const CallEnd end = !is_wanted ? CallEnd::kFailed : call(link, state.get());
    if (is_own) dropService(link);
    const std::lock_guard<std::mutex> lock(state->mutex);
    state->end = end;
    state->is_over = true;
    state->over.notify_all();
  }

  static CallEnd call(const ros::ServiceServerLinkPtr& link, State* state) {
    if (!link) return CallEnd::kNobody;
    ros::SerializedMessage response;
    if (!link->call(ros::serialization::serializeMessage(state->request), response)) {
      return CallEnd::kFailed;
    }
    try {
      ros::serialization::deserializeMessage(response, state->response);
    } catch (const std::exception&) {
      return CallEnd::kFailed;  // an answer that is none: the other node is another version
    }
    return CallEnd::kAnswered;
  }

  const std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace planar_bin_picking_ros
