// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Prints what is read of parts, with no ROS master.
/// Exit status: 0; 2, with one line on stderr for each, where a part is refused.

#include "command_line.h"

#include "planar_bin_picking/part/part_summary.h"

#include <cstdio>
#include <exception>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

const char kName[] = "describe_part";
const char kUsage[] =
    "usage: describe_part PART [PART ...]\n"
    "\n"
    "Prints what is read of each part as YAML, one document each.\n"
    "\n"
    "  PART              a part: its .dxf or its .yaml\n"
    "\n"
    "Exit status: 0; 2 where a part is refused, which is said on stderr in one line; the others\n"
    "are described all the same.\n";

int run(const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    if (isHelp(argument)) {
      std::fputs(kUsage, stdout);
      return kDone;
    }
    if (argument.size() > 1 && argument[0] == '-')
      throw std::invalid_argument("unknown option \"" + argument + "\"; see --help");
  }
  if (arguments.empty()) throw std::invalid_argument("no part is given; see --help");
  int status = kDone;
  bool first = true;
  for (const std::string& path : arguments) {
    try {
      const PartModel part(loadPartFile(path));
      std::fputs(((first ? "" : "---\n") + toYaml(describePart(part))).c_str(), stdout);
      first = false;
    } catch (const std::exception& e) {
      status = refuse(kName, e.what());
    }
  }
  return status;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  return runTool(kName, [&] { return run({argv + 1, argv + argc}); });
}
