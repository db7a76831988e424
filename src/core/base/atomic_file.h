// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct NamedContent {
  std::string path, content;
};

using RenameFile = std::function<int(const char* from, const char* to)>;

/// Replaces files together: either all are new afterwards, or all are as they were. What was there
/// is kept as `<path>.before`. Needs nothing of the file system but that it can rename, hence works
/// on FAT, too.
/// @param rename_file  the system's, but for tests of file systems that fail
/// @throws std::runtime_error  the path and the system's reason; nothing has changed
void writeTogether(const std::vector<NamedContent>& files,
                   const RenameFile& rename_file = std::rename);

/// @throws std::runtime_error  no file can be made in this folder: the system's reason
void checkWritable(const std::string& folder);

}  // namespace planar_bin_picking
