// The model of {{ robot }} as a plugin of inverse_dynamics_solver.
#include <pluginlib/class_list_macros.hpp>
#include <rclcpp/parameter.hpp>

#include <inverse_dynamics_solver/exceptions.hpp>
#include <inverse_dynamics_solver/inverse_dynamics_solver.hpp>

#include "model.hpp"

namespace {{ package }}
{
using inverse_dynamics_solver::InvalidParameterValueException;
using Vector = Eigen::VectorXd;

/// Vectors have an entry for each joint, in the order of joint_names(). Parameters, in the given
/// namespace: X, digest, joints{{ ", gravity" if gravity_input }}, and friction (false): whether getTorques includes friction. Effects
/// of the robot file, such as springs, are not in these torques.
class InverseDynamicsSolver : public inverse_dynamics_solver::InverseDynamicsSolver
{
public:
  void initialize(
    rclcpp::node_interfaces::NodeParametersInterface::ConstSharedPtr parameters_interface,
    const std::string & param_namespace, const std::string & robot_description) override
  {
    std::vector<double> X;
    std::string digest;
    Names names = joint_names();
{% if gravity_input %}
    std::vector<double> gravity(DOWN.begin(), DOWN.end());
{% endif %}
    const std::string start = param_namespace.empty() ? "" : param_namespace + ".";
    rclcpp::Parameter found;
    const auto has = [&](const char * name) {
        return parameters_interface && parameters_interface->get_parameter(start + name, found);
      };
    if (has("X")) {
      X = found.as_double_array();
    }
    if (has("digest")) {
      digest = found.as_string();
    }
    if (has("joints")) {
      names = found.as_string_array();
    }
    if (has("friction")) {
      friction_ = found.as_bool();
    }
{% if gravity_input %}
    if (has("gravity")) {
      gravity = found.as_double_array();
    }
{% endif %}
    const std::string reasons[] = {
{% if gravity_input %}
      take_gravity(gravity, gravity_),
{% endif %}
      take_parameters(X, digest, X_),
      joint_mismatch(robot_description, names),
    };
    for (const std::string & reason : reasons) {
      if (!reason.empty()) {
        throw InvalidParameterValueException(reason);
      }
    }
    rigid_ = X_;
    std::fill(rigid_.begin() + {{ name }}_INERTIAL, rigid_.end(), Real(0));
    ready_ = true;
  }

  Eigen::MatrixXd getInertiaMatrix(const Vector & joint_positions) const override
  {
    const Joints q = joints(joint_positions);
    Eigen::Matrix<Real, JOINTS, JOINTS> M;  // symmetric: the order of its entries is the same
    {{ name }}_mass_matrix(q.data(), X_.data(), M.data());
    return M.template cast<double>();
  }

  Vector getCoriolisVector(
    const Vector & joint_positions, const Vector & joint_velocities) const override
  {
    const Vector still = Vector::Zero(JOINTS);
    return torques(joint_positions, joint_velocities, still) - getGravityVector(joint_positions);
  }

  Vector getGravityVector(const Vector & joint_positions) const override
  {
    const Joints q = joints(joint_positions);
    Joints tau;
    {{ name }}_gravity_torque(q.data(), X_.data(){{ ", gravity_.data()" if gravity_input }}, tau.data());
    return vector(tau);
  }

  Vector getFrictionVector(const Vector & joint_velocities) const override
  {
    const Joints qd = joints(joint_velocities);
    Joints tau;
    {{ name }}_friction(qd.data(), X_.data(), tau.data());
    return vector(tau);
  }

  Vector getTorques(
    const Vector & joint_positions, const Vector & joint_velocities,
    const Vector & joint_accelerations) const override
  {
    Vector tau = torques(joint_positions, joint_velocities, joint_accelerations);
    if (friction_) {
      tau += getFrictionVector(joint_velocities);
    }
    return tau;
  }

private:
  Joints joints(const Vector & values) const
  {
    if (!ready_) {
      throw inverse_dynamics_solver::UninitializedException();
    }
    if (values.size() != static_cast<Eigen::Index>(JOINTS)) {
      throw std::invalid_argument("vector of " + std::to_string(values.size()) +
        " entries; the model has " + std::to_string(JOINTS) + " joints: " + listed(joint_names()));
    }
    Joints out;
    std::copy_n(values.data(), JOINTS, out.begin());
    return out;
  }

  static Vector vector(const Joints & values)
  {
    return Eigen::Map<const Eigen::Matrix<Real, JOINTS, 1>>(values.data()).template cast<double>();
  }

  /// Return the torques of the rigid bodies.
  Vector torques(
    const Vector & positions, const Vector & velocities, const Vector & accelerations) const
  {
    const Joints q = joints(positions);
    const Joints qd = joints(velocities);
    const Joints qdd = joints(accelerations);
    Joints tau;
    {{ name }}_inverse_dynamics(q.data(), qd.data(), qdd.data(), rigid_.data(){{ ", gravity_.data()" if gravity_input }}, tau.data());
    return vector(tau);
  }

  bool ready_ = false;
  bool friction_ = false;
  Parameters X_{};
  Parameters rigid_{};  // X without friction and effects
{% if gravity_input %}
  Gravity gravity_ = DOWN;
{% endif %}
};
}  // namespace {{ package }}

PLUGINLIB_EXPORT_CLASS(
  {{ package }}::InverseDynamicsSolver, inverse_dynamics_solver::InverseDynamicsSolver)
