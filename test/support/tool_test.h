// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Runs a command line tool as a user does: its exit status, what it prints and what it writes.

#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

namespace planar_bin_picking {

class ToolTest : public testing::Test {
 protected:
  explicit ToolTest(const std::string& program) : program_(program) {}

  /// @return  the exit status, -1 where a signal ended it; what it printed is in out_ and error_
  int run(const std::string& arguments) {
    const std::string out = dir_.path("out.txt"), error = dir_.path("error.txt");
    // A program that hangs is an error of its own and must not hold up all the others.
    const int status = std::system(
        ("timeout 100 " + program_ + " " + arguments + " >" + out + " 2>" + error).c_str());
    out_ = read(out);
    error_ = read(error);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  static std::string read(const std::string& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  /// Refused with status 2, nothing on stdout and one line that holds all of `words`.
  testing::AssertionResult refused(const std::string& arguments,
                                   const std::vector<std::string>& words) {
    const int status = run(arguments);
    bool good = status == 2 && out_.empty() && std::count(error_.begin(), error_.end(), '\n') == 1;
    for (const std::string& word : words) good = good && error_.find(word) != std::string::npos;
    return (good ? testing::AssertionSuccess() : testing::AssertionFailure())
           << "status " << status << ", says: " << error_;
  }

  /// With any option, it prints its name and the package's version.
  testing::AssertionResult printsItsVersion(const std::string& arguments) {
    const std::string package = read(std::string(PACKAGE_DIR) + "/package.xml");
    const std::size_t begin = package.find("<version>") + 9;
    const std::string version = package.substr(begin, package.find("</version>") - begin);
    const std::string name = std::filesystem::path(program_).filename().string();
    const int status = run(arguments + " --version");
    const bool good = status == 0 && out_ == name + " " + version + "\n" && error_.empty();
    return (good ? testing::AssertionSuccess() : testing::AssertionFailure())
           << "status " << status << ", says: " << out_ << error_;
  }

  TempDir dir_;
  std::string out_, error_;

 private:
  std::string program_;
};

}  // namespace planar_bin_picking
