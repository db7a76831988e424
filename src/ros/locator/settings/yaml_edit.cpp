// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/settings/yaml_edit.h"

#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking_ros {

namespace fs = std::filesystem;

namespace {

using Lines = std::vector<std::string>;

constexpr std::size_t kNowhere = std::string::npos;

std::string joined(const YamlPath& path) {
  std::string text;
  for (const std::string& key : path) text += (text.empty() ? "" : "/") + key;
  return text;
}

Lines linesOf(const std::string& text) {
  Lines lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::size_t indentOf(const std::string& line) { return line.find_first_not_of(' '); }

/// Neither empty nor a comment nor a mark of a document.
bool says(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first != kNowhere && line[first] != '#' && line.compare(0, 3, "---") != 0;
}

/// Lines of one map: those from `begin` on that are indented so far, or farther.
struct Block {
  std::size_t begin = 0, end = 0, indent = 0;
};

/// The map that begins with the first line that says something, down to one that is less indented.
Block blockAt(const Lines& lines, const std::size_t begin, const std::size_t deeper_than) {
  Block block{begin, begin, deeper_than};
  for (std::size_t i = begin; i < lines.size(); ++i) {
    if (!says(lines[i])) continue;
    const std::size_t indent = indentOf(lines[i]);
    if (block.end == begin) {
      if (indent < deeper_than) break;
      block.indent = indent;
    } else if (indent < block.indent) {
      break;
    }
    block.end = i + 1;
  }
  return block;
}

/// The line with this key in the block's own map.
std::size_t lineOf(const Lines& lines, const Block& block, const std::string& key) {
  for (std::size_t i = block.begin; i < block.end; ++i) {
    const std::string& line = lines[i];
    if (says(line) && indentOf(line) == block.indent &&
        line.compare(block.indent, key.size() + 1, key + ":") == 0)
      return i;
  }
  return kNowhere;
}

/// In place of what stands behind the key; a comment stays where it is, if there is room.
void replaceValue(std::string* line, const std::size_t begin, const std::string& value) {
  std::size_t comment = line->find(" #", begin);
  const std::string tail = comment == kNowhere ? "" : line->substr(comment + 1);
  std::string text = line->substr(0, begin) + " " + value;
  if (!tail.empty()) {
    while (text.size() < comment + 1) text += ' ';
    if (text.back() != ' ') text += ' ';
  }
  *line = text + tail;
}

void setValue(Lines* lines, const YamlPath& path, const std::string& value) {
  Block block = blockAt(*lines, 0, 0);
  if (block.begin == block.end) block.begin = block.end = lines->size();  // below comments
  for (std::size_t depth = 0; depth < path.size(); ++depth) {
    const bool is_last = depth + 1 == path.size();
    std::size_t at = lineOf(*lines, block, path[depth]);
    const bool is_new = at == kNowhere;
    if (is_new) {
      at = block.end;
      const std::string line = std::string(block.indent, ' ') + path[depth] + ":";
      lines->insert(lines->begin() + static_cast<std::ptrdiff_t>(at), line);
    }
    if (is_last) {
      replaceValue(&(*lines)[at], block.indent + path[depth].size() + 1, value);
    } else {
      const std::size_t deeper = block.indent + 1;
      block = blockAt(*lines, at + 1, deeper);
      if (block.end == block.begin) block.indent = deeper + 1;  // two spaces
    }
  }
}

YAML::Node parsed(const std::string& text) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(error.what());
  }
}

void setNode(YAML::Node node, const YamlPath& path, const std::string& value) {
  for (const std::string& key : path) {
    if (node.IsDefined() && !node.IsNull() && !node.IsMap())
      throw std::invalid_argument(joined(path) + " stands below what is no map");
    node.reset(node[key]);
  }
  node = YAML::Load(value);
}

bool isThis(const std::string& text, const YAML::Node& expected) {
  try {
    return YAML::Dump(YAML::Load(text)) == YAML::Dump(expected);
  } catch (const YAML::Exception&) {
    return false;
  }
}

}  // namespace

std::string yamlNumber(const double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.setf(std::ios::fixed);
  constexpr int kDecimals = 9;  // finer than any of these numbers is meant
  out.precision(kDecimals);
  out << value;
  std::string text = out.str();
  text.erase(text.find_last_not_of('0') + 1);
  return text.back() == '.' ? text + "0" : text;
}

std::string withYamlValues(const std::string& text, const std::map<YamlPath, std::string>& values) {
  const YAML::Node before = parsed(text);
  if (!before.IsNull() && !before.IsMap()) throw std::invalid_argument("is no map at its top");
  // A copy of nothing would be a node of its own, which copies of it do not share.
  YAML::Node expected = before.IsNull() ? YAML::Node(YAML::NodeType::Map) : YAML::Clone(before);
  Lines lines = linesOf(text);
  for (const auto& [path, value] : values) {
    setNode(expected, path, value);
    setValue(&lines, path, value);
  }
  std::string result;
  for (const std::string& line : lines) result += line + "\n";
  // What the lines came to is decided by a parser, not by the rules above.
  if (!isThis(result, expected)) {
    std::string keys;
    for (const auto& entry : values) keys += (keys.empty() ? "" : ", ") + joined(entry.first);
    throw std::invalid_argument(
        "cannot be changed without rewriting it: write each key on a line of "
        "its own, or change these by hand: " +
        keys);
  }
  return result;
}

void saveYamlValues(const std::string& path, const std::map<YamlPath, std::string>& values) {
  const auto fail = [&](const std::string& why) { return std::runtime_error(path + ": " + why); };
  std::ifstream file(path, std::ios::binary);
  if (!file) throw fail(std::string("cannot be read: ") + std::strerror(errno));
  const std::string before{std::istreambuf_iterator<char>(file), {}};
  std::string after;
  try {
    after = withYamlValues(before, values);
  } catch (const std::invalid_argument& error) {
    throw fail(error.what());
  }
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream out(name, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw fail(name + " cannot be written; look at the folder's rights and at the disk");
  };
  // Where the path is a link, what it leads to; with the rights that the file has.
  const std::string there = fs::canonical(path).string();
  const std::string partial = there + ".partial";
  write(there + ".before", before);
  write(partial, after);
  fs::permissions(partial, fs::status(there).permissions());
  fs::rename(partial, there);
}

}  // namespace planar_bin_picking_ros
