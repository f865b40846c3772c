// Signatures of kinematics_interface: without robot_description before 1.2 (Humble); with the inverse
// from 1.3 on (Jazzy); with the difference of frames after that (Lyrical).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "rclcpp/rclcpp.hpp"

namespace kinematics_interface
{
class KinematicsInterface
{
public:
  using Parameters = std::shared_ptr<rclcpp::node_interfaces::NodeParametersInterface>;
  virtual ~KinematicsInterface() = default;
#if DISTRIBUTION == HUMBLE
  virtual bool initialize(Parameters parameters, const std::string & end_effector_name) = 0;
#else
  virtual bool initialize(
    const std::string & robot_description, Parameters parameters,
    const std::string & param_namespace) = 0;
  virtual bool calculate_jacobian_inverse(
    const Eigen::VectorXd & q, const std::string & link,
    Eigen::Matrix<double, Eigen::Dynamic, 6> & inverse) = 0;
#endif
#if DISTRIBUTION == LYRICAL
  virtual bool calculate_frame_difference(
    Eigen::Matrix<double, 7, 1> & x_a, Eigen::Matrix<double, 7, 1> & x_b, double dt,
    Eigen::Matrix<double, 6, 1> & delta_x) = 0;
#endif
  virtual bool convert_cartesian_deltas_to_joint_deltas(
    const Eigen::VectorXd & q, const Eigen::Matrix<double, 6, 1> & delta_x,
    const std::string & link, Eigen::VectorXd & delta_q) = 0;
  virtual bool convert_joint_deltas_to_cartesian_deltas(
    const Eigen::VectorXd & q, const Eigen::VectorXd & delta_q, const std::string & link,
    Eigen::Matrix<double, 6, 1> & delta_x) = 0;
  virtual bool calculate_link_transform(
    const Eigen::VectorXd & q, const std::string & link, Eigen::Isometry3d & transform) = 0;
  virtual bool calculate_jacobian(
    const Eigen::VectorXd & q, const std::string & link,
    Eigen::Matrix<double, 6, Eigen::Dynamic> & jacobian) = 0;
};
}  // namespace kinematics_interface
