// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "robot_server/line_server.h"

#include "support/matchers.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <thread>

namespace planar_bin_picking_ros {
namespace {

class Client {
 public:
  explicit Client(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    const timeval patience{10, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~Client() { close(socket_); }
  void send(const std::string& text) const {
    ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
  }
  /// With its end; shorter where the server has closed the connection.
  std::string line() const {
    std::string text;
    for (char c; (text.empty() || text.back() != '\n') && recv(socket_, &c, 1, 0) == 1;) text += c;
    return text;
  }
  std::string ask(const std::string& text) const {
    send(text);
    return line();
  }

 private:
  int socket_;
};

/// Answers a line with how many the client has sent and the line; "slow" takes a while.
LineServer::Answer makeEcho() {
  const auto count = std::make_shared<int>(0);
  return [count](const std::string& line) {
    if (line == "slow") std::this_thread::sleep_for(std::chrono::milliseconds(300));
    return std::to_string(++*count) + " " + line + "\n";
  };
}

LineServer::Settings settings(int clients) { return {"127.0.0.1", 0, clients, "busy\n", "long\n"}; }

TEST(LineServer, AnswersLinesOfEachClientInTheirOrder) {
  const LineServer server(settings(2), makeEcho);
  const Client a(server.port()), b(server.port());
  EXPECT_EQ(a.ask("one\n"), "1 one\n");
  EXPECT_EQ(b.ask("uno\r\n"), "1 uno\n");
  a.send("two\nthree\nfo");
  EXPECT_EQ(a.line(), "2 two\n");
  EXPECT_EQ(a.line(), "3 three\n");
  EXPECT_EQ(a.ask("ur\n"), "4 four\n");
  EXPECT_EQ(b.ask("\n"), "2 \n");
}

TEST(LineServer, SendsAwayWhoIsTooMany) {
  const LineServer server(settings(1), makeEcho);
  {
    const Client a(server.port());
    EXPECT_EQ(a.ask("one\n"), "1 one\n");
    const Client b(server.port());
    EXPECT_EQ(b.line(), "busy\n");
    EXPECT_EQ(b.line(), "");
    EXPECT_EQ(a.ask("two\n"), "2 two\n");
  }
  for (int i = 0; i < 100; ++i) {  // its place is free as soon as the server has seen it go
    const Client c(server.port());
    if (c.ask("one\n") == "1 one\n") return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  FAIL() << "the place of a client that went is never free again";
}

TEST(LineServer, EndsALineWithoutAnEnd) {
  const LineServer server(settings(2), makeEcho);
  const Client flood(server.port());
  EXPECT_EQ(flood.ask(std::string(LineServer::kLineMost + 1, 'x')), "long\n");
  EXPECT_EQ(flood.line(), "");
  EXPECT_EQ(Client(server.port()).ask("one\n"), "1 one\n");
}

TEST(LineServer, SlowAndVanishingClientsHarmNobody) {
  const LineServer server(settings(20), makeEcho);
  const Client slow(server.port());
  slow.send("sl");  // and nothing for a while
  for (int i = 0; i < 10; ++i)
    Client(server.port()).send("slow\nslow\n");  // gone before the answer
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(Client(server.port()).ask("one\n"), "1 one\n");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(250));
  EXPECT_EQ(slow.ask("ow\n"), "1 slow\n");
}

/// Of the server's connection to a client: seconds until the system asks whether it is still there,
/// as /proc/net/tcp has it ("02:" and hundredths); negative where it never does.
double secondsToKeepalive(int port) {
  char local[16];
  std::snprintf(local, sizeof local, ":%04X", port);
  std::ifstream table("/proc/net/tcp");
  for (std::string row; std::getline(table, row);) {
    std::istringstream words(row);
    std::string number, from, to, state, queues, timer;
    words >> number >> from >> to >> state >> queues >> timer;
    const std::string established = "01";
    if (state != established || from.find(local) == std::string::npos) continue;
    return timer.compare(0, 3, "02:") == 0 ? std::stoul(timer.substr(3), nullptr, 16) / 100.0
                                           : -1.0;
  }
  ADD_FAILURE() << "no connection of port " << port;
  return -1.0;
}

TEST(LineServer, AsksSoonWhetherAQuietClientIsStillThere) {
  const LineServer server(settings(2), makeEcho);
  const Client client(server.port());
  EXPECT_EQ(client.ask("one\n"), "1 one\n");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // what was sent is confirmed
  EXPECT_GT(secondsToKeepalive(server.port()), 5.0);
  EXPECT_LE(secondsToKeepalive(server.port()), 31.0);
}

TEST(LineServer, TakesArbitraryBytes) {
  const LineServer server(settings(2), makeEcho);
  const Client client(server.port());
  EXPECT_EQ(client.ask(std::string("\0\xFF\x80\n", 4)), std::string("1 \0\xFF\x80\n", 6));
}

TEST(LineServer, EndsAtOnceWhileClientsAreConnected) {
  std::optional<LineServer> server;
  server.emplace(settings(2), makeEcho);
  const Client client(server->port());
  EXPECT_EQ(client.ask("one\n"), "1 one\n");
  server.reset();
  EXPECT_EQ(client.line(), "");
}

TEST(LineServer, SaysWhyItCannotListen) {
  const LineServer server(settings(1), makeEcho);
  LineServer::Settings same = settings(1);
  same.port = server.port();
  EXPECT_TRUE(planar_bin_picking::refuses([&] { LineServer second(same, makeEcho); },
                                          {std::to_string(server.port()), "in use"}));
  LineServer::Settings bad = settings(1);
  bad.address = "robot.local";
  EXPECT_TRUE(
      planar_bin_picking::refuses([&] { LineServer second(bad, makeEcho); }, {"four numbers"}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
