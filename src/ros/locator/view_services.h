// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// RefinePart and NextView, and the second camera of a cell that has two: everything that takes
/// more than one picture.

#include "input/image_source.h"
#include "input/picture_host.h"
#include "locator/cell_frames.h"
#include "locator/pick_keeper.h"
#include "locator/settings/cell_params.h"
#include "locator/views/view_keeper.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/views/look.h"

#include <planar_bin_picking/LocatePart.h>
#include <planar_bin_picking/NextView.h>
#include <planar_bin_picking/RefinePart.h>
#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class ViewServices {
 public:
  /// What it needs of the locator.
  struct Host : PictureHost {
    /// Takes an answer through the pick policy and publishes what is left.
    std::function<PickKeeper::Offered(Answer answer, const Standing& standing,
                                      const std::string& caller)>
        offer;
    /// Where everything stands at an image in target_frame; with the flange where that is told.
    std::function<Standing(const std_msgs::Header& image,
                           const geometry_msgs::TransformStamped& flange)>
        standing;
    /// A camera that was proposed, for people.
    std::function<void(const Eigen::Isometry3d& T_target_camera,
                       const planar_bin_picking::Camera& camera)>
        show;
  };

  /// @param image_nh  its queue takes in images
  /// @param call_nh   its queue serves calls
  /// @throws std::exception  the hand-eye file, or a parameter, is wrong: which one and why
  ViewServices(const ros::NodeHandle& image_nh, const ros::NodeHandle& call_nh,
               const ros::NodeHandle& pnh, const planar_bin_picking::LocatorParams& params,
               const CellParams& cell, Host host);

  void close();  ///< ends waiting and serving

  /// An answer was given, whose parts may be looked at again.
  void keep(const Answer& answer, const PickKeeper::Offered& offered,
            const PickKeeper::Frames& frames);

  /// Where there is a second camera, what the first has found is confirmed and refined in both.
  /// @return  whether there is one
  /// @throws Refusal
  bool lookInSecond(const ros::Time& not_before, const ros::Duration& timeout,
                    const Eigen::Isometry3d& T_target_camera, Answer* answer);

 private:
  template <class Service>
  using Event = ros::ServiceEvent<typename Service::Request, typename Service::Response>;
  using RefinePart = planar_bin_picking::RefinePart;
  using NextView = planar_bin_picking::NextView;
  struct Looks;

  bool serveRefine(Event<RefinePart>& event);
  bool serveNextView(NextView::Request& request, NextView::Response& response);
  void refine(const std::string& caller, const RefinePart::Request& request,
              RefinePart::Response* response);
  /// Looks at each part in the new picture.
  Looks lookAt(std::vector<KeptPart> parts, const Answer& now,
               const Eigen::Isometry3d& T_target_camera) const;
  /// Through the pick policy, and out to everybody.
  void offerRefined(const std::string& caller, Answer answer, const Standing& standing, Looks seen,
                    RefinePart::Response* response);
  void conclude(RefinePart::Response* response) const;
  void propose(const NextView::Request& request, NextView::Response* response);
  /// @throws Refusal  NO_TRANSFORM of NextView
  Eigen::Isometry3d flangeFrom(const std::string& camera, const std::string& flange,
                               const ros::Time& stamp) const;

  const planar_bin_picking::LocatorParams params_;
  const CellParams cell_;
  const Host host_;
  ViewKeeper keeper_;
  std::unique_ptr<ImageSource> second_;
  ros::ServiceServer refine_service_, next_service_;
};

}  // namespace planar_bin_picking_ros
