// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dxf_text.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <locale>
#include <set>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// One code and its value: the atom of a DXF file.
struct Group {
  int code = 0;
  std::string value;
  std::size_t line = 0;
};

/// A group with code 0 or 9 and all that belongs to it.
using Record = std::vector<Group>;

[[noreturn]] void refuse(const std::string& what) { throw std::runtime_error(what); }

[[noreturn]] void refuse(std::size_t line, const std::string& what) {
  refuse("line " + std::to_string(line) + ": " + what);
}

std::string readBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse("cannot be read; check the path and its permissions");
  std::ostringstream bytes;
  bytes << file.rdbuf();
  const std::string content = bytes.str();
  if (content.empty()) refuse("is empty; export the drawing again");
  const std::string remedy = "; save the drawing as an ASCII DXF file";
  if (content.compare(0, 18, "AutoCAD Binary DXF") == 0) refuse("is a binary DXF file" + remedy);
  if (content.compare(0, 4, "AC10") == 0) refuse("is a DWG file" + remedy);
  if (content.find('\0') != std::string::npos) refuse("is not a text file" + remedy);
  return content;
}

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Parses all of `text` as a number, whatever the locale.
template <class T>
bool parse(const std::string& text, T* value) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  return in >> *value && (in >> std::ws).eof();
}

std::vector<Group> splitIntoGroups(std::string content) {
  if (content.compare(0, 3, "\xef\xbb\xbf") == 0) content.erase(0, 3);  // byte order mark
  std::istringstream lines(content);
  std::vector<Group> groups;
  std::string code, value;
  for (std::size_t line = 1; std::getline(lines, code); line += 2) {
    Group group;
    group.line = line;
    if (!parse(code, &group.code)) {
      if (trimmed(code).empty() && (lines >> std::ws).eof()) break;
      refuse(line, groups.empty() ? "this is not a DXF file"
                                  : "\"" + trimmed(code).substr(0, 40) +
                                        "\" is no group code; the file is damaged");
    }
    if (!std::getline(lines, value)) break;
    group.value = trimmed(value);
    if (group.code == 999) continue;  // a comment
    groups.push_back(group);
    if (group.code == 0 && group.value == "EOF") return groups;
  }
  refuse("ends without its EOF line: it is truncated; copy or export it again");
}

std::vector<Record> splitIntoRecords(const std::vector<Group>& groups) {
  std::vector<Record> records;
  for (const Group& group : groups) {
    if (group.code == 0 || group.code == 9 || records.empty()) records.emplace_back();
    records.back().push_back(group);
  }
  return records;
}

bool isReal(int code) { return (code >= 10 && code <= 59) || (code >= 210 && code <= 239); }
bool isInteger(int code) { return code >= 60 && code <= 79; }

const Group* find(const Record& record, int code) {
  const auto it = std::find_if(record.begin() + 1, record.end(),
                               [code](const Group& group) { return group.code == code; });
  return it == record.end() ? nullptr : &*it;
}

int integerOf(const Record& record, int code, int otherwise) {
  const Group* group = find(record, code);
  int value = otherwise;
  return group != nullptr && parse(group->value, &value) ? value : otherwise;
}

void checkNumbers(const Record& record) {
  const std::string& type = record.front().value;
  for (const Group& group : record) {
    double real = 0.0;
    int integer = 0;
    const bool good = (!isReal(group.code) || (parse(group.value, &real) && std::isfinite(real))) &&
                      (!isInteger(group.code) || parse(group.value, &integer));
    if (!good) {
      refuse(group.line + 1, "\"" + group.value.substr(0, 40) + "\" in this " + type +
                                 " is not a number; the file is damaged");
    }
  }
}

/// dxflib allots memory by the count that the file states, and remembers it from one entity to the
/// next where it is absent: state the true count, first of all groups.
void stateCount(Record& record, int count_code, int item_code) {
  const auto items = std::count_if(record.begin(), record.end(), [item_code](const Group& group) {
    return group.code == item_code;
  });
  const Group* stated = find(record, count_code);
  int count = 0;
  if (stated != nullptr && !(parse(stated->value, &count) && count == items)) {
    refuse(stated->line + 1, "this " + record.front().value + " states " + stated->value +
                                 " items and has " + std::to_string(items) +
                                 "; the file is damaged, export it again");
  }
  const std::size_t line = record.front().line;
  record.erase(std::remove_if(record.begin() + 1, record.end(),
                              [&](const Group& group) { return group.code == count_code; }),
               record.end());
  record.insert(record.begin() + 1, Group{count_code, std::to_string(items), line});
}

const std::set<std::string> kGeometry = {"LINE",       "ARC",      "CIRCLE", "ELLIPSE", "SPLINE",
                                         "LWPOLYLINE", "POLYLINE", "VERTEX", "SEQEND",  "INSERT"};
const std::set<std::string> kUnreadable = {"REGION", "BODY",  "3DSOLID", "SURFACE",
                                           "MESH",   "MLINE", "HELIX",   "ACAD_PROXY_ENTITY"};
const std::set<std::string> kStructure = {"BLOCK", "ENDBLK"};

/// Entities that nobody sees: invisible, or on the sheet around the model.
bool isHidden(const Record& record) {
  return integerOf(record, 60, 0) == 1 || integerOf(record, 67, 0) == 1;
}

/// The frame that a spline-fit polyline was made from; not part of the curve.
bool isSplineFrame(const Record& record) {
  return record.front().value == "VERTEX" && (integerOf(record, 70, 0) & 16) != 0;
}

/// Copies the records that matter, checked, into the smaller file.
class Filter {
 public:
  explicit Filter(DxfText* out) : out_(out) {}

  void add(Record record) {
    const std::string& type = record.front().value;
    if (type == "SECTION") section_ = find(record, 2) != nullptr ? find(record, 2)->value : "";
    if (type == "SECTION" || type == "ENDSEC" || type == "EOF") return write(record);
    if (section_ == "HEADER") {
      if (type == "$INSUNITS") write(record);
    } else if (section_ == "TABLES") {
      if (type == "TABLE" || type == "ENDTAB" || type == "LAYER") write(record);
    } else if (section_ == "BLOCKS" || section_ == "ENTITIES") {
      addEntity(std::move(record));
    }
  }

 private:
  void addEntity(Record record) {
    const std::string type = record.front().value;
    if (kStructure.count(type) != 0) return write(record);
    // A hidden polyline takes its vertices along.
    if (type != "VERTEX" && type != "SEQEND") skipping_ = isHidden(record);
    if (skipping_ || isSplineFrame(record)) return;
    if (kUnreadable.count(type) != 0) {
      const Group* layer = find(record, 8);
      out_->unreadable.push_back({type, layer != nullptr ? layer->value : "0"});
    }
    if (kGeometry.count(type) == 0) {
      skipping_ = true;  // vertices and attributes that follow belong to it
      return;
    }
    if (type == "LWPOLYLINE") stateCount(record, 90, 10);
    if (type == "SPLINE") {
      stateCount(record, 72, 40);
      stateCount(record, 73, 10);
      stateCount(record, 74, 11);
    }
    write(record);
  }

  void write(const Record& record) {
    checkNumbers(record);
    for (const Group& group : record) {
      // The reader library has a limit on a line's length; nothing long matters.
      if (group.code >= 300 || group.value.size() > 500) continue;
      out_->text += std::to_string(group.code) + "\n" + group.value + "\n";
    }
  }

  DxfText* out_;
  std::string section_;
  bool skipping_ = false;
};

}  // namespace

DxfText readDxfText(const std::string& path) {
  const std::vector<Group> groups = splitIntoGroups(readBytes(path));
  DxfText out;
  Filter filter(&out);
  for (Record& record : splitIntoRecords(groups)) filter.add(std::move(record));
  return out;
}

}  // namespace planar_bin_picking
