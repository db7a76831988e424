// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Prints what is read of parts, with no ROS master.
/// Exit status: 0; 2, with one line on stderr for each, where a part is refused.

#include "command_line.h"
#include "write_picture.h"

#include "planar_bin_picking/part/part_summary.h"

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace planar_bin_picking {
namespace {

const char kName[] = "describe_part";

/// @param pictures  folder for a picture of each; "" = none
int run(const std::vector<std::string>& paths, const std::string& pictures) {
  int status = kDone;
  bool first = true;
  for (const std::string& path : paths) {
    try {
      const PartModel part(loadPartFile(path));
      std::fputs(((first ? "" : "---\n") + toYaml(describePart(part))).c_str(), stdout);
      first = false;
      if (!pictures.empty()) writePartPicture(pictures + "/" + part.name() + ".png", part);
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
  std::vector<std::string> parts;
  std::string pictures;
  CLI::App app("Prints what is read of each part as YAML, one document each.", kName);
  app.add_option("PART", parts, "a part: its .dxf or its .yaml")->required();
  app.add_option("--pictures", pictures, "a folder: writes a picture of each part into it")
      ->type_name("FOLDER")
      ->check(CLI::ExistingDirectory);
  app.footer(
      "Exit status: 0; 2 where a part is refused, which is said on stderr in one line; the\n"
      "others are described all the same.");
  return runTool(&app, argc, argv, [&] { return run(parts, pictures); });
}
