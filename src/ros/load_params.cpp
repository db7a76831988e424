// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "load_params.h"

#include "names.h"

#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace planar_bin_picking_ros {

using planar_bin_picking::LocatorParams;
using XmlRpc::XmlRpcValue;

namespace {

/// Takes values out of a flattened tree; what is left at the end was not known.
class Reader {
 public:
  Reader(const XmlRpcValue& tree, std::string name) : name_(std::move(name)) {
    if (tree.getType() != XmlRpcValue::TypeStruct) {
      throw std::invalid_argument("~" + name_ + " is not a tree of parameters");
    }
    flatten(tree, "");
  }

  /// A number or bool, with its range.
  template <class Number>
  void operator()(const std::string& key, Number& member, const Number min, const Number max) {
    const auto value = take(key);
    if (!value.valid()) return;
    member = number(key, value, Number{});
    if (!(member >= min && member <= max)) {
      std::ostringstream range;
      range << "must lie in " << min << " .. " << max;
      fail(key, value, range.str());
    }
  }

  void operator()(const std::string& key, std::string& member) {
    const auto value = take(key);
    if (!value.valid()) return;
    if (value.getType() != XmlRpcValue::TypeString) fail(key, value, "must be a text");
    member = static_cast<const std::string&>(value);
  }

  void operator()(const std::string& key, std::vector<double>& member) {
    const auto value = take(key);
    if (!value.valid()) return;
    if (value.getType() != XmlRpcValue::TypeArray) fail(key, value, "must be a list of numbers");
    member.clear();
    for (int i = 0; i < value.size(); ++i) member.push_back(number(key, value[i], 0.0));
  }

  void finish() const {
    if (values_.empty()) return;
    std::string keys;
    for (const auto& [key, value] : values_)
      keys += (keys.empty() ? "~" : ", ~") + name_ + "/" + key;
    throw std::invalid_argument("unknown parameter " + keys + "; check its spelling and its place");
  }

 private:
  void flatten(const XmlRpcValue& tree, const std::string& prefix) {
    for (const auto& [key, value] : tree) {
      if (value.getType() == XmlRpcValue::TypeStruct) {
        flatten(value, prefix + key + "/");
      } else {
        values_[prefix + key] = value;
      }
    }
  }

  XmlRpcValue take(const std::string& key) {
    const auto found = values_.find(key);
    if (found == values_.end()) return {};
    const XmlRpcValue value = found->second;
    values_.erase(found);
    return value;
  }

  bool number(const std::string& key, const XmlRpcValue& value, bool) const {
    if (value.getType() != XmlRpcValue::TypeBoolean) fail(key, value, "must be true or false");
    return static_cast<const bool&>(value);
  }

  int number(const std::string& key, const XmlRpcValue& value, int) const {
    if (value.getType() != XmlRpcValue::TypeInt) fail(key, value, "must be a whole number");
    return static_cast<const int&>(value);
  }

  double number(const std::string& key, const XmlRpcValue& value, double) const {
    if (value.getType() == XmlRpcValue::TypeInt) return static_cast<const int&>(value);
    if (value.getType() != XmlRpcValue::TypeDouble) fail(key, value, "must be a number");
    return static_cast<const double&>(value);
  }

  [[noreturn]] void fail(const std::string& key, const XmlRpcValue& value,
                         const std::string& rule) const {
    std::ostringstream message;
    message << "parameter ~" << name_ << "/" << key << " is " << value << ", but " << rule;
    throw std::invalid_argument(message.str());
  }

  std::string name_;
  std::map<std::string, XmlRpcValue> values_;
};

/// Prints any field; the ranges are not shown.
struct Printer {
  std::ostringstream text;
  template <class Member, class... Range>
  void operator()(const std::string& key, const Member& member, Range...) {
    text << "\n  " << key << ": " << member;
  }
  template <class... Range>
  void operator()(const std::string& key, const std::vector<double>& member, Range...) {
    text << "\n  " << key << ":";
    for (const double number : member) text << " " << number;
  }
};

}  // namespace

XmlRpcValue readTree(const ros::NodeHandle& pnh, const std::string& name) {
  XmlRpcValue tree;
  if (!pnh.getParam(name, tree)) tree.begin();  // makes it an empty struct
  return tree;
}

LocatorParams loadLocatorParams(const XmlRpcValue& tree) {
  LocatorParams params;
  Reader reader(tree, kLocatorParams);
  planar_bin_picking::forEachField(params, reader);
  reader.finish();
  planar_bin_picking::validate(params);
  return params;
}

CellParams loadCellParams(const XmlRpcValue& tree) {
  CellParams params;
  Reader reader(tree, kCellParams);
  CellParams::fields(params, reader);
  reader.finish();
  validate(params);
  return params;
}

CalibratorParams loadCalibratorParams(const XmlRpcValue& tree) {
  CalibratorParams params;
  Reader reader(tree, kCalibratorParams);
  CalibratorParams::fields(params, reader);
  reader.finish();
  validate(params);
  return params;
}

HdrNodeParams loadHdrNodeParams(const XmlRpcValue& tree) {
  HdrNodeParams params;
  Reader reader(tree, kHdrParams);
  HdrNodeParams::fields(params, reader);
  reader.finish();
  validate(params);
  return params;
}

planar_bin_picking::PickParams loadPickParams(const XmlRpcValue& tree) {
  planar_bin_picking::PickParams params;
  Reader reader(tree, kPickParams);
  planar_bin_picking::PickParams::fields(params, reader);
  reader.finish();
  return params;
}

std::string describe(const LocatorParams& params) {
  Printer printer;
  planar_bin_picking::forEachField(params, printer);
  return printer.text.str();
}

std::string describe(const CellParams& params) {
  Printer printer;
  CellParams::fields(params, printer);
  return printer.text.str();
}

std::string describe(const CalibratorParams& params) {
  Printer printer;
  CalibratorParams::fields(params, printer);
  return printer.text.str();
}

std::string describe(const planar_bin_picking::PickParams& params) {
  Printer printer;
  planar_bin_picking::PickParams::fields(params, printer);
  return printer.text.str();
}

std::string describe(const HdrNodeParams& params) {
  Printer printer;
  HdrNodeParams::fields(params, printer);
  return printer.text.str();
}

}  // namespace planar_bin_picking_ros
