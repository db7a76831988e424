// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the command line tools have in common: options of the form `--name value`, and one line on
/// stderr with exit status 2 for whatever is wrong with what they were given.

#include <cstdio>
#include <exception>
#include <new>
#include <string>

namespace planar_bin_picking {

inline constexpr int kDone = 0, kBadInput = 2;  ///< exit status

inline bool isHelp(const std::string& argument) { return argument == "--help" || argument == "-h"; }

/// Says in one line, whatever the message holds, why input is refused.
inline int refuse(const std::string& tool, std::string message) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  std::fprintf(stderr, "%s: %s\n", tool.c_str(), message.c_str());
  return kBadInput;
}

/// @param work  returns the exit status
template <class Work>
int runTool(const std::string& tool, Work&& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return refuse(tool, "out of memory; is the input what it is meant to be?");
  } catch (const std::exception& e) {
    return refuse(tool, e.what());
  }
}

}  // namespace planar_bin_picking
