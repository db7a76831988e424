// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/snapshot/snapshot.h"

#include "base/regular_file.h"
#include "planar_bin_picking/image/camera_file.h"
#include "snapshot/grey_file.h"
#include "snapshot/snapshot_text.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 1u << 30;  // of an image

void writeFile(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file)
    throw std::runtime_error(path.string() + ": cannot be written; check the disk and the folder");
}

/// Below a folder, and not out of it again.
fs::path within(const fs::path& folder, const std::string& name) {
  const fs::path relative = fs::path(name).lexically_normal();
  if (name.empty() || relative.is_absolute() || *relative.begin() == "..")
    throw std::runtime_error("\"" + name + "\" is no file within the snapshot " + folder.string());
  return folder / relative;
}

void writeInto(const fs::path& folder, const Snapshot& snapshot,
               const std::vector<SnapshotPartFile>& part_files,
               const std::vector<SnapshotText>& texts) {
  std::vector<std::string> parts;
  for (const SnapshotPartFile& file : part_files) {
    const fs::path to = within(folder / "parts", file.inside);
    fs::create_directories(to.parent_path());
    fs::copy_file(file.path, to, fs::copy_options::overwrite_existing);
    if (file.is_part) parts.push_back(file.inside);
  }
  writeFile(folder / "image.pgm", toPgm(snapshot.grey));
  writeFile(folder / "camera_info.yaml", cameraText(snapshot.camera));
  writeFile(folder / "locator.yaml", paramsText(snapshot.params));
  writeFile(folder / "request.yaml", requestText(snapshot.request, snapshot.version, parts));
  writeFile(folder / "result.yaml", snapshot.result);
  for (const SnapshotText& text : texts) writeFile(within(folder, text.name), text.text);
}

}  // namespace

std::string resultText(const LocateResult& result) { return detectionsText(result); }

void writeSnapshot(const std::string& folder, const Snapshot& snapshot,
                   const std::vector<SnapshotPartFile>& part_files,
                   const std::vector<SnapshotText>& texts) {
  const fs::path partial = fs::path(folder + ".partial");
  try {
    fs::remove_all(partial);
    fs::create_directories(partial);
    writeInto(partial, snapshot, part_files, texts);
    fs::rename(partial, folder);
  } catch (...) {
    std::error_code ignored;  // what went wrong first is what counts
    fs::remove_all(partial, ignored);
    throw;
  }
}

Snapshot readSnapshot(const std::string& folder) {
  const fs::path root(folder);
  if (!fs::is_directory(root))
    throw std::runtime_error(folder + ": is no folder; give that of a snapshot");
  const auto path = [&](const char* name) { return (root / name).string(); };
  RequestFile file = readRequestFile(path("request.yaml"));
  for (const std::string& part : file.parts) {
    file.request.parts.push_back(
        std::make_shared<const PartModel>(loadPartFile(within(root / "parts", part).string())));
  }
  return {file.version,
          fromPgm(readRegularFile(path("image.pgm"), kMostBytes), path("image.pgm")),
          loadCamera(path("camera_info.yaml")),
          loadLocatorParams(path("locator.yaml")),
          file.request,
          readRegularFile(path("result.yaml"), kMostBytes)};
}

}  // namespace planar_bin_picking
