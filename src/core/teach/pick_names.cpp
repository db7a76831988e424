// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "teach/pick_names.h"

#include "base/yaml_file.h"
#include "base/yaml_text.h"
#include "teach/text_edit.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace planar_bin_picking {

std::string withNames(const std::string& text, const FormerNames& names) {
  if (names.empty()) return text;
  TextEdit edit(text);
  for (const YAML::Node& entry : YAML::Load(text)["pick_poses"]) {
    const YAML::Node node = entry["name"];
    const std::string former = node.Scalar();
    const auto renamed = std::find_if(names.begin(), names.end(),
                                      [&](const auto& pair) { return pair.second == former; });
    if (renamed == names.end()) continue;
    const auto at = static_cast<std::size_t>(node.Mark().pos);
    const bool is_quoted = at < text.size() && (text[at] == '"' || text[at] == '\'');
    const std::string written = is_quoted ? text[at] + former + text[at] : former;
    if (text.compare(at, written.size(), written) != 0)
      throw std::runtime_error("the file's pick_poses cannot be changed safely: write the name " +
                               former + " as that word, without anchors (&) and aliases (*)");
    edit.replace(at, at + written.size(), yamlText(renamed->first));
  }
  return edit.result();
}

}  // namespace planar_bin_picking
