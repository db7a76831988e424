// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/parallel.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace planar_bin_picking {
namespace {

/// How often body was called for each i, with at most `most` other threads.
std::vector<int> callsWith(int n, int threads, int most, int* started) {
  std::vector<int> calls(static_cast<std::size_t>(n), 0);
  parallelFor(
      n, threads, [&](int i) { ++calls[static_cast<std::size_t>(i)]; },
      [&](const auto& work) {
        // As std::thread where the system has no more of them.
        if (*started == most) {
          throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
        }
        ++*started;
        return std::thread(work);
      });
  return calls;
}

TEST(Parallel, EachOneIsDoneOnce) {
  for (const int threads : {0, 1, 2, 7, 1000}) {
    std::vector<int> calls(100, 0);
    parallelFor(100, threads, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(calls, std::vector<int>(100, 1)) << threads << " threads";
  }
}

TEST(Parallel, NoMoreThreadsThanThereIsWorkFor) {
  int started = 0;
  EXPECT_EQ(callsWith(3, 8, 100, &started), std::vector<int>(3, 1));
  EXPECT_EQ(started, 2);
}

TEST(Parallel, GoesOnWhereThreadsCannotStart) {
  for (const int most : {0, 1, 3}) {
    int started = 0;
    EXPECT_EQ(callsWith(500, 8, most, &started), std::vector<int>(500, 1));
    EXPECT_EQ(started, most);
  }
}

/// As the above, with the system's own limit of processes.
int worksUnderALimit() {
  constexpr uid_t kNobody = 65534;
  constexpr rlimit kNoMore{1, 1};
  if (getuid() == 0 && setuid(kNobody) != 0) return 2;  // root has no limit
  if (setrlimit(RLIMIT_NPROC, &kNoMore) != 0) return 3;
  try {
    std::thread([] {}).join();
    return 4;  // the limit does not hold
  } catch (const std::system_error&) {
  }
  std::vector<int> calls(500, 0);
  parallelFor(500, 8, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
  return calls == std::vector<int>(500, 1) ? 0 : 5;
}

TEST(Parallel, GoesOnUnderALimitOfProcesses) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) _exit(worksUnderALimit());
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(Parallel, ThrowsWhatABodyThrew) {
  for (const int threads : {1, 4}) {
    std::string what;
    try {
      parallelFor(50, threads, [](int i) {
        if (i == 20) throw std::runtime_error("number 20");
      });
    } catch (const std::runtime_error& e) {
      what = e.what();
    }
    EXPECT_EQ(what, "number 20") << threads << " threads";
  }
}

}  // namespace
}  // namespace planar_bin_picking
