// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Lines over TCP: each client sends a line and gets a line. No ROS. Each client has a thread of
/// its own, so that a slow one, or one that has vanished, keeps no other waiting.

#include <atomic>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>

namespace planar_bin_picking_ros {

class LineServer {
 public:
  /// A client's lines, without their ends, to answers, with theirs.
  using Answer = std::function<std::string(const std::string& line)>;

  struct Settings {
    std::string address;   ///< IPv4, of this machine; 127.0.0.1: only programs on it can connect
    int port = 0;          ///< 0 = any that is free
    int clients_max = 1;   ///< further ones get `busy` and are sent away
    std::string busy;      ///< with its end
    std::string too_long;  ///< answer to a line without an end; then the client is sent away
  };

  /// @param new_client  called for each one, in its thread; makes what answers its lines
  /// @throws std::runtime_error  address and port cannot be listened at: the system's reason
  LineServer(const Settings& settings, std::function<Answer()> new_client);
  ~LineServer();
  LineServer(const LineServer&) = delete;
  LineServer& operator=(const LineServer&) = delete;

  int port() const { return port_; }

  static constexpr std::size_t kLineMost = 1024;  ///< bytes

 private:
  struct Client {
    int socket = -1;
    std::atomic<bool> is_done{false};
    std::thread thread;
  };

  void listen();
  void accept();
  void serve(Client* client);
  /// @return  false where the client is to be sent away
  bool answerLines(int socket, const Answer& answer, std::string* pending);
  void reap(bool all);

  const Settings settings_;
  const std::function<Answer()> new_client_;
  int listener_ = -1, port_ = 0;
  int wake_[2] = {-1, -1};  ///< closed at the end, which every thread that waits sees
  std::list<std::unique_ptr<Client>> clients_;  ///< of the listening thread alone
  std::thread thread_;
};

}  // namespace planar_bin_picking_ros
