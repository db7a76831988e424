// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "robot_server/line_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace planar_bin_picking_ros {

namespace {

constexpr timeval kSendMost{2, 0};  // a client that takes nothing in for so long is sent away

void close(int* descriptor) {
  if (*descriptor >= 0) ::close(*descriptor);
  *descriptor = -1;
}

/// @return  false where the client takes nothing in, or is gone
bool sendAll(const int socket, const std::string& text) {
  std::size_t sent = 0;
  while (sent < text.size()) {
    const ssize_t n = send(socket, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    sent += static_cast<std::size_t>(n);
  }
  return true;
}

/// Waits for data, or for the end. @return  whether there is data
bool waitFor(const int descriptor, const int end) {
  pollfd wanted[2] = {{descriptor, POLLIN, 0}, {end, POLLIN, 0}};
  constexpr int kForever = -1;
  while (poll(wanted, 2, kForever) < 0)
    if (errno != EINTR) return false;
  return wanted[1].revents == 0;
}

/// A controller without power sends no end: it is asked for after so long without a word, then
/// again and again, and is gone after so many questions. The system's own two hours would keep its
/// place.
constexpr int kIdleSeconds = 30, kAgainSeconds = 10, kQuestions = 3;

/// A dead peer is noticed within a minute, and answers go out at once.
void prepare(const int socket) {
  const int on = 1;
  setsockopt(socket, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  setsockopt(socket, IPPROTO_TCP, TCP_KEEPIDLE, &kIdleSeconds, sizeof kIdleSeconds);
  setsockopt(socket, IPPROTO_TCP, TCP_KEEPINTVL, &kAgainSeconds, sizeof kAgainSeconds);
  setsockopt(socket, IPPROTO_TCP, TCP_KEEPCNT, &kQuestions, sizeof kQuestions);
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &kSendMost, sizeof kSendMost);
}

}  // namespace

LineServer::LineServer(const Settings& settings, std::function<Answer()> new_client)
    : settings_(settings), new_client_(std::move(new_client)) {
  try {
    listen();
  } catch (...) {
    close(&listener_);
    throw;
  }
  thread_ = std::thread(&LineServer::accept, this);
}

LineServer::~LineServer() {
  close(&wake_[1]);  // the other end becomes readable
  thread_.join();
  close(&wake_[0]);
  close(&listener_);
}

void LineServer::listen() {
  const auto fail = [&](const std::string& why) {
    throw std::runtime_error("cannot listen at " + settings_.address + ":" +
                             std::to_string(settings_.port) + ": " + why +
                             "; correct ~server/address and ~server/port");
  };
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(settings_.port));
  if (inet_pton(AF_INET, settings_.address.c_str(), &address.sin_addr) != 1)
    fail("the address is none of four numbers");
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (listener_ < 0) fail(std::strerror(errno));
  const int on = 1;
  setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  constexpr int kWaiting = 8;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener_, any, sizeof address) != 0 || ::listen(listener_, kWaiting) != 0)
    fail(std::strerror(errno));
  socklen_t size = sizeof address;
  getsockname(listener_, any, &size);
  port_ = ntohs(address.sin_port);
  if (pipe2(wake_, O_CLOEXEC) != 0) fail(std::strerror(errno));
}

void LineServer::reap(const bool all) {
  for (auto client = clients_.begin(); client != clients_.end();) {
    if (!all && !(*client)->is_done) {
      ++client;
      continue;
    }
    (*client)->thread.join();
    close(&(*client)->socket);
    client = clients_.erase(client);
  }
}

void LineServer::accept() {
  while (waitFor(listener_, wake_[0])) {
    const int socket = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    reap(false);
    if (socket < 0) {
      constexpr useconds_t kBreath = 100000;  // out of descriptors, say: that may pass
      usleep(kBreath);
      continue;
    }
    prepare(socket);
    if (static_cast<int>(clients_.size()) >= settings_.clients_max) {
      sendAll(socket, settings_.busy);
      ::close(socket);
      continue;
    }
    auto client = std::make_unique<Client>();
    client->socket = socket;
    try {
      client->thread = std::thread(&LineServer::serve, this, client.get());
    } catch (
        const std::system_error&) {  // the system has no thread to spare: it may have one later
      sendAll(socket, settings_.busy);
      ::close(socket);
      continue;
    }
    clients_.push_back(std::move(client));
  }
  reap(true);
}

bool LineServer::answerLines(const int socket, const Answer& answer, std::string* pending) {
  for (std::size_t end; (end = pending->find('\n')) != std::string::npos;) {
    std::string line = pending->substr(0, end);
    pending->erase(0, end + 1);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!sendAll(socket, answer(line))) return false;
  }
  if (pending->size() <= kLineMost) return true;
  sendAll(socket, settings_.too_long);
  return false;
}

void LineServer::serve(Client* client) {
  const Answer answer = new_client_();
  std::string pending;
  char buffer[kLineMost];
  while (waitFor(client->socket, wake_[0])) {
    const ssize_t n = recv(client->socket, buffer, sizeof buffer, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    pending.append(buffer, static_cast<std::size_t>(n));
    if (!answerLines(client->socket, answer, &pending)) break;
  }
  shutdown(client->socket, SHUT_RDWR);
  client->is_done = true;
}

}  // namespace planar_bin_picking_ros
