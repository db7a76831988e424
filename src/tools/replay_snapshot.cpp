// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Locates a snapshot's parts again and says whether the result is the same, byte for byte.
/// Exit status: 0 the same; 1 another; 2, with one line on stderr, on bad input.

#include "command_line.h"

#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/snapshot/snapshot.h"

#include <cstdio>
#include <string>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr int kDiffers = 1;

int run(const std::vector<std::string>& folders) {
  int status = kDone;
  for (const std::string& folder : folders) {
    const Snapshot snapshot = readSnapshot(folder);
    const Locator locator(snapshot.params);
    const std::string result =
        resultText(locator.locate(snapshot.grey, snapshot.camera, snapshot.request));
    const bool is_same = result == snapshot.result;
    std::printf("%s: written by version %s, replayed by %s: %s\n", folder.c_str(),
                snapshot.version.c_str(), PACKAGE_VERSION, is_same ? "the same" : "differs");
    if (is_same) continue;
    status = kDiffers;
    std::printf("--- then\n%s--- now\n%s", snapshot.result.c_str(), result.c_str());
  }
  return status;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  std::vector<std::string> folders;
  CLI::App app("Locates the parts of snapshots again and compares the results.", "replay_snapshot");
  app.add_option("FOLDER", folders, "a snapshot, as the locator saved it")->required();
  app.footer(
      "Exit status: 0 where all results are the same, 1 where one differs; 2, with one line on\n"
      "stderr, on bad input.");
  return runTool(&app, argc, argv, [&] { return run(folders); });
}
