// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the command line tools have in common: options as CLI11 reads them, --help and --version,
/// and one line on stderr with exit status 2 for whatever is wrong with what they were given.

#include <CLI/CLI.hpp>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <locale>
#include <new>
#include <sstream>
#include <string>

namespace planar_bin_picking {

inline constexpr int kDone = 0, kBadInput = 2;  ///< exit status

/// What is wrong with the value of an option; empty where nothing is.
inline std::string wrongMetres(const std::string& value) {
  std::istringstream in(value);
  in.imbue(std::locale::classic());
  double metres = 0.0;
  const bool good = in >> metres && (in >> std::ws).eof() && std::isfinite(metres) && metres > 0.0;
  return good ? "" : "is \"" + value + "\", must be metres greater than 0";
}

inline std::string wrongCount(const std::string& value) {
  const char* end = value.data() + value.size();
  std::uint32_t count = 0;
  const auto [after, error] = std::from_chars(value.data(), end, count);
  const bool good = error == std::errc() && after == end;
  return good ? "" : "is \"" + value + "\", must be a whole number, 0 for all";
}

inline std::string wrongPath(const std::string& value) {
  return value.empty() ? "needs a value" : "";
}

/// Says in one line, whatever the message holds, why input is refused.
inline int refuse(const std::string& tool, std::string message) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  std::fprintf(stderr, "%s: %s\n", tool.c_str(), message.c_str());
  return kBadInput;
}

/// Reads the command line, does the work, and says what is wrong with either.
/// @param work  returns the exit status
template <class Work>
int runTool(CLI::App* app, int argc, char** argv, Work&& work) {
  const std::string tool = app->get_name();
  app->add_flag_callback(
      "--version",
      [&] {
        std::printf("%s %s\n", tool.c_str(), PACKAGE_VERSION);
        throw CLI::Success();
      },
      "print the version of this package and end");
  try {
    app->parse(argc, argv);
    return work();
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app->exit(e);  // help, or the version
    return refuse(tool, std::string(e.what()) + "; see --help");
  } catch (const std::bad_alloc&) {
    return refuse(tool, "out of memory; is the input what it is meant to be?");
  } catch (const std::exception& e) {
    return refuse(tool, e.what());
  }
}

}  // namespace planar_bin_picking
