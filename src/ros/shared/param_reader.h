// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// ROS parameters -> parameter structs, driven by the structs' own lists of fields. A key that no
/// field has is an error, so that a typing error cannot pass for a default.

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

/// The parameters below `~<name>`; an empty struct where there are none.
XmlRpc::XmlRpcValue readTree(const ros::NodeHandle& pnh, const std::string& name);

/// Takes values out of a flattened tree; what is left at the end was not known.
class ParamReader {
 public:
  ParamReader(const XmlRpc::XmlRpcValue& tree, std::string name) : name_(std::move(name)) {
    if (tree.getType() != XmlRpc::XmlRpcValue::TypeStruct) {
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
    if (value.getType() != XmlRpc::XmlRpcValue::TypeString) fail(key, value, "must be a text");
    member = static_cast<const std::string&>(value);
  }

  void operator()(const std::string& key, std::vector<double>& member) {
    const auto value = take(key);
    if (!value.valid()) return;
    if (value.getType() != XmlRpc::XmlRpcValue::TypeArray)
      fail(key, value, "must be a list of numbers");
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
  void flatten(const XmlRpc::XmlRpcValue& tree, const std::string& prefix) {
    for (const auto& [key, value] : tree) {
      if (value.getType() == XmlRpc::XmlRpcValue::TypeStruct) {
        flatten(value, prefix + key + "/");
      } else {
        values_[prefix + key] = value;
      }
    }
  }

  XmlRpc::XmlRpcValue take(const std::string& key) {
    const auto found = values_.find(key);
    if (found == values_.end()) return {};
    const XmlRpc::XmlRpcValue value = found->second;
    values_.erase(found);
    return value;
  }

  bool number(const std::string& key, const XmlRpc::XmlRpcValue& value, bool) const {
    if (value.getType() != XmlRpc::XmlRpcValue::TypeBoolean)
      fail(key, value, "must be true or false");
    return static_cast<const bool&>(value);
  }

  int number(const std::string& key, const XmlRpc::XmlRpcValue& value, int) const {
    if (value.getType() != XmlRpc::XmlRpcValue::TypeInt) fail(key, value, "must be a whole number");
    return static_cast<const int&>(value);
  }

  double number(const std::string& key, const XmlRpc::XmlRpcValue& value, double) const {
    if (value.getType() == XmlRpc::XmlRpcValue::TypeInt) return static_cast<const int&>(value);
    if (value.getType() != XmlRpc::XmlRpcValue::TypeDouble) fail(key, value, "must be a number");
    return static_cast<const double&>(value);
  }

  [[noreturn]] void fail(const std::string& key, const XmlRpc::XmlRpcValue& value,
                         const std::string& rule) const {
    std::ostringstream message;
    message << "parameter ~" << name_ << "/" << key << " is " << value << ", but " << rule;
    throw std::invalid_argument(message.str());
  }

  std::string name_;
  std::map<std::string, XmlRpc::XmlRpcValue> values_;
};

/// Prints any field; the ranges are not shown.
struct ParamPrinter {
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

/// @param tree  as readTree returns it
/// @param name  of the tree, for messages
/// @param each  calls a visitor for every field of a Params: each(params, visitor)
/// @throws std::invalid_argument  unknown key, wrong type or value out of range: key, value,
/// allowed
template <class Params, class Each>
Params readFields(const XmlRpc::XmlRpcValue& tree, const std::string& name, const Each& each) {
  Params params;
  ParamReader reader(tree, name);
  each(params, reader);
  reader.finish();
  return params;
}

template <class Params>
Params readFields(const XmlRpc::XmlRpcValue& tree, const std::string& name) {
  return readFields<Params>(tree, name,
                            [](auto& params, auto& visit) { Params::fields(params, visit); });
}

/// "key: value" of every field, one a line, for the log at start.
template <class Params, class Each>
std::string printFields(const Params& params, const Each& each) {
  ParamPrinter printer;
  each(params, printer);
  return printer.text.str();
}

template <class Params>
std::string printFields(const Params& params) {
  return printFields(params,
                     [](auto& fields_of, auto& visit) { Params::fields(fields_of, visit); });
}

}  // namespace planar_bin_picking_ros
