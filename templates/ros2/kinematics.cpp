// Frames and Jacobians of {{ robot }} as a plugin of kinematics_interface.
#include <Eigen/Dense>
#include <pluginlib/class_list_macros.hpp>
#include <rclcpp/logging.hpp>

#include <kinematics_interface/kinematics_interface.hpp>

#include <memory>

#include "model.hpp"

namespace {{ package }}
{
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using Inverse = Eigen::Matrix<double, Eigen::Dynamic, 6>;
using Pose = Eigen::Matrix<double, 7, 1>;
using Twist = Eigen::Matrix<double, 6, 1>;
using ParametersInterface = std::shared_ptr<rclcpp::node_interfaces::NodeParametersInterface>;

/// Joints are those of joint_names(), links those of links() and the root of robot_description.
/// Parameters: `base`, the link in whose frame poses and Jacobians are, by default the root; `joints`,
/// the names of the joints, and `prefix`, that of links, in robot_description; `alpha`, the damping.
///
/// Distributions have other base classes. Methods without `override` are virtual in some of them.
class Kinematics : public kinematics_interface::KinematicsInterface
{
public:
  using kinematics_interface::KinematicsInterface::calculate_jacobian;
  using kinematics_interface::KinematicsInterface::calculate_link_transform;
  using kinematics_interface::KinematicsInterface::convert_cartesian_deltas_to_joint_deltas;
  using kinematics_interface::KinematicsInterface::convert_joint_deltas_to_cartesian_deltas;

  // Humble
  bool initialize(ParametersInterface parameters, const std::string &)
  {
    return start("", parameters, "");
  }

  // Jazzy and later
  bool initialize(
    const std::string & robot_description, ParametersInterface parameters,
    const std::string & param_namespace)
  {
    const std::string prefix = param_namespace.empty() ? "" : param_namespace + ".";
    return start(robot_description, parameters, prefix);
  }

  bool calculate_link_transform(
    const Eigen::VectorXd & joint_pos, const std::string & link_name,
    Eigen::Isometry3d & transform) override
  {
    const Link * const link = usable(joint_pos, link_name);
    if (link == nullptr) {
      return false;
    }
    transform = base_.inverse() * pose(*link, joints(joint_pos));
    return true;
  }

  bool calculate_jacobian(
    const Eigen::VectorXd & joint_pos, const std::string & link_name, Jacobian & jacobian) override
  {
    const Link * const link = usable(joint_pos, link_name);
    if (link == nullptr) {
      return false;
    }
    jacobian.setZero(6, JOINTS);
    if (link->joint == 0u) {
      return true;
    }
    const Joints q = joints(joint_pos);
    const Real point[3] = {link->frame[3], link->frame[7], link->frame[11]};
    Eigen::Matrix<Real, JOINTS, 6> columns;  // row-major (6, n) in memory
    {{ name }}_link_jacobian(q.data(), link->joint, point, columns.data());
    const Jacobian in_zero = columns.template cast<double>().transpose();
    const Eigen::Matrix3d turn = base_.linear().transpose();
    jacobian.topRows<3>() = turn * in_zero.topRows<3>();
    jacobian.bottomRows<3>() = turn * in_zero.bottomRows<3>();
    return true;
  }

  /// The damped inverse J' (J J' + alpha I)^-1.
  bool calculate_jacobian_inverse(
    const Eigen::VectorXd & joint_pos, const std::string & link_name, Inverse & jacobian_inverse)
  {
    Jacobian J;
    if (!calculate_jacobian(joint_pos, link_name, J)) {
      return false;
    }
    const Eigen::Matrix<double, 6, 6> damped =
      J * J.transpose() + alpha_ * Eigen::Matrix<double, 6, 6>::Identity();
    jacobian_inverse = damped.ldlt().solve(J).transpose();
    return true;
  }

  bool convert_cartesian_deltas_to_joint_deltas(
    const Eigen::VectorXd & joint_pos, const Twist & delta_x, const std::string & link_name,
    Eigen::VectorXd & delta_theta) override
  {
    Inverse inverse;
    if (!calculate_jacobian_inverse(joint_pos, link_name, inverse)) {
      return false;
    }
    delta_theta = inverse * delta_x;
    return true;
  }

  bool convert_joint_deltas_to_cartesian_deltas(
    const Eigen::VectorXd & joint_pos, const Eigen::VectorXd & delta_theta,
    const std::string & link_name, Twist & delta_x) override
  {
    Jacobian J;
    if (!right_size(delta_theta) || !calculate_jacobian(joint_pos, link_name, J)) {
      return false;
    }
    delta_x = J * delta_theta;
    return true;
  }

  /// The constant twist that takes x_a to x_b in dt: rotation vector, in the axes of the base. Poses
  /// are x, y, z and the quaternion x, y, z, w.
  bool calculate_frame_difference(const Pose & x_a, const Pose & x_b, double dt, Twist & delta_x)
  {
    if (!(dt > 0.0)) {
      RCLCPP_ERROR(logger(), "the period is %g s; accepted: above 0", dt);
      return false;
    }
    const Eigen::Quaterniond a = Eigen::Quaterniond(x_a.tail<4>()).normalized();
    const Eigen::Quaterniond b = Eigen::Quaterniond(x_b.tail<4>()).normalized();
    const Eigen::AngleAxisd turn(b * a.conjugate());
    delta_x.head<3>() = (x_b.head<3>() - x_a.head<3>()) / dt;
    delta_x.tail<3>() = turn.axis() * turn.angle() / dt;
    return true;
  }

  bool calculate_frame_difference(Pose & x_a, Pose & x_b, double dt, Twist & delta_x)
  {
    const Pose & a = x_a;
    const Pose & b = x_b;
    return calculate_frame_difference(a, b, dt, delta_x);
  }

private:
  static rclcpp::Logger logger()
  {
    return rclcpp::get_logger("{{ package }}");
  }

  bool start(
    std::string description, const ParametersInterface & parameters, const std::string & start)
  {
    Names names = joint_names();
    std::string base;
    rclcpp::Parameter found;
    if (description.empty() && parameters->get_parameter("robot_description", found)) {
      description = found.as_string();
    }
    if (parameters->get_parameter(start + "alpha", found)) {
      alpha_ = found.as_double();
    }
    if (parameters->get_parameter(start + "base", found)) {
      base = found.as_string();
    }
    if (parameters->get_parameter(start + "joints", found)) {
      names = found.as_string_array();
    }
    if (parameters->get_parameter(start + "prefix", found)) {
      prefix_ = found.as_string();
    }
    const std::string reason =
      description.empty() ? "no robot_description" : joint_mismatch(description, names);
    if (!reason.empty()) {
      RCLCPP_ERROR(logger(), "%s", reason.c_str());
      return false;
    }
    root_ = urdf::parseURDF(description)->getRoot()->name;
    base = base.empty() ? root_ : base;
    const Link * const link = find(base);
    if (link == nullptr || link->joint != 0u) {
      RCLCPP_ERROR(logger(), "base is '%s'; accepted: a link that does not move", base.c_str());
      return false;
    }
    base_ = fixed(*link);
    ready_ = true;
    return true;
  }

  const Link * find(const std::string & link_name) const
  {
    static const Link root{"", 0u, SAME};  // frame 0 of the model is that of the root
    return link_name == root_ ? &root : find_link(link_name, prefix_);
  }

  bool right_size(const Eigen::VectorXd & values) const
  {
    if (ready_ && values.size() == static_cast<Eigen::Index>(JOINTS)) {
      return true;
    }
    RCLCPP_ERROR(logger(), "%s: %d entries for %d joints",
      ready_ ? "wrong size" : "initialize was not called", static_cast<int>(values.size()),
      static_cast<int>(JOINTS));
    return false;
  }

  /// Return the link for joint positions of the right size; nullptr, with a message, otherwise.
  const Link * usable(const Eigen::VectorXd & joint_pos, const std::string & link_name) const
  {
    const Link * const link = find(link_name);
    if (link == nullptr) {
      RCLCPP_ERROR(logger(), "no link %s; links: %s", link_name.c_str(), listed_links().c_str());
    }
    return right_size(joint_pos) ? link : nullptr;
  }

  static Joints joints(const Eigen::VectorXd & values)
  {
    Joints q;
    std::copy_n(values.data(), JOINTS, q.begin());
    return q;
  }

  static Eigen::Isometry3d isometry(const Real * transform)
  {
    Eigen::Isometry3d out;
    out.matrix() =
      Eigen::Map<const Eigen::Matrix<Real, 4, 4, Eigen::RowMajor>>(transform).template cast<double>();
    return out;
  }

  static Eigen::Isometry3d fixed(const Link & link)
  {
    return isometry(link.frame);
  }

  /// Return the frame of a link in frame 0 of the model.
  static Eigen::Isometry3d pose(const Link & link, const Joints & q)
  {
    if (link.joint == 0u) {
      return fixed(link);
    }
    Real frames[{{ link_count }}][16];
    {{ name }}_frames(q.data(), &frames[0][0]);
    return isometry(frames[link.joint - 1u]) * fixed(link);
  }

  bool ready_ = false;
  double alpha_ = 5e-6;
  std::string root_;
  std::string prefix_;
  Eigen::Isometry3d base_ = Eigen::Isometry3d::Identity();
};
}  // namespace {{ package }}

PLUGINLIB_EXPORT_CLASS({{ package }}::Kinematics, kinematics_interface::KinematicsInterface)
