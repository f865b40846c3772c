// A chainable controller for ros2_control that sends joint torques of the model of {{ robot }}.
#include <Eigen/Dense>
#include <geometry_msgs/msg/inertia_stamped.hpp>
#include <pluginlib/class_list_macros.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp/version.h>

#include <controller_interface/chainable_controller_interface.hpp>
#if __has_include(<controller_interface/version.h>)
#include <controller_interface/version.h>
#endif

#include <limits>
#include <memory>
#include <mutex>

#include "model.hpp"

// Humble has rclcpp 16, Jazzy 28. From Lyrical on (controller_interface 6), handles keep references.
#if RCLCPP_VERSION_MAJOR >= 28
#define {{ name }}_TIMED_REFERENCES
#endif
#if defined(CONTROLLER_INTERFACE_VERSION_MAJOR) && CONTROLLER_INTERFACE_VERSION_MAJOR >= 6
#define {{ name }}_LISTED_REFERENCES
#endif

namespace {{ package }}
{
namespace
{
using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
using controller_interface::return_type;
using geometry_msgs::msg::InertiaStamped;

constexpr double NONE = std::numeric_limits<double>::quiet_NaN();

// Handles of point releases differ within a distribution: they have get_optional, which gives nothing
// while another thread writes, or get_value alone.
template <class Handle>
auto value_of(const Handle & handle, double before, int)
-> decltype(handle.get_optional().value_or(before))
{
  return handle.get_optional().value_or(before);
}

template <class Handle>
double value_of(const Handle & handle, double, long)
{
  return handle.get_value();
}

/// Return why a load is refused; "" if X has it now. The message states mass, centre of mass, and
/// inertia about the centre of mass, in the frame of the link frame_id.
std::string add_load(const InertiaStamped & message, const std::string & prefix, Parameters & X)
{
  const auto & body = message.inertia;
  const std::string & frame = message.header.frame_id;
  const Link * const link = find_link(frame, prefix);
  if (link == nullptr) {
    return "frame_id '" + frame + "' is not a link of the model; links: " + listed_links();
  }
  if (link->joint == 0u) {
    return "link " + frame + " does not move";
  }
  Eigen::Vector3d center(body.com.x, body.com.y, body.com.z);
  Eigen::Matrix3d inertia;
  inertia << body.ixx, body.ixy, body.ixz, body.ixy, body.iyy, body.iyz, body.ixz, body.iyz, body.izz;
  if (!std::isfinite(body.m) || !center.allFinite() || !inertia.allFinite() || body.m < 0.0) {
    return "mass, centre of mass and inertia must be finite, and the mass at least 0";
  }
  const Eigen::Vector3d moments = inertia.selfadjointView<Eigen::Lower>().eigenvalues();
  if (moments.minCoeff() < -1e-9 * moments.cwiseAbs().maxCoeff()) {
    return "the inertia has a negative principal moment";
  }
  if (!(body.m > 0.0)) {
    return "";
  }
  using Transform = Eigen::Matrix<Real, 4, 4, Eigen::RowMajor>;
  const Eigen::Matrix4d place = Eigen::Map<const Transform>(link->frame).cast<double>();
  const Eigen::Matrix3d turn = place.topLeftCorner<3, 3>();
  center = turn * center + place.topRightCorner<3, 1>();
  inertia = turn * inertia * turn.transpose();
  const Real com[3] = {Real(center[0]), Real(center[1]), Real(center[2])};
  const Real about_com[6] = {Real(inertia(0, 0)), Real(inertia(0, 1)), Real(inertia(0, 2)),
    Real(inertia(1, 1)), Real(inertia(1, 2)), Real(inertia(2, 2))};
  const int status = {{ name }}_add_body(X.data(), link->joint, Real(body.m), com, about_com);
  return status == {{ name }}_OK ? "" : "the model cannot carry a load on link " + frame;
}
}  // namespace

class ModelController : public controller_interface::ChainableControllerInterface
{
public:
  CallbackReturn on_init() override
  {
    try {
      declare();
    } catch (const std::exception & error) {  // a parameter of another type: integers in a list
      RCLCPP_ERROR(get_node()->get_logger(), "%s", error.what());
      return CallbackReturn::ERROR;
    }
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_configure(const rclcpp_lifecycle::State &) override
  {
    const std::lock_guard<std::mutex> lock(configuring_);
    payload_.reset();
    const std::string reason = take_settings();
    if (!reason.empty()) {
      RCLCPP_ERROR(get_node()->get_logger(), "%s", reason.c_str());
      return CallbackReturn::ERROR;
    }
    exchange_.reset(X_);
    payload_ = get_node()->create_subscription<InertiaStamped>("~/payload", rclcpp::QoS(1),
      [this](const std::shared_ptr<const InertiaStamped> message) {take_load(*message);});
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_cleanup(const rclcpp_lifecycle::State &) override
  {
    payload_.reset();
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_activate(const rclcpp_lifecycle::State &) override
  {
    hold_.fill(Real(NONE));
    measured_.fill(NONE);
    forget_references();
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) override
  {
    send(Joints{});
    forget_references();
    return CallbackReturn::SUCCESS;
  }

  InterfaceConfiguration command_interface_configuration() const override
  {
    return interfaces({"effort"});
  }

  InterfaceConfiguration state_interface_configuration() const override
  {
    return interfaces({"position", "velocity"});
  }

protected:
#ifdef {{ name }}_LISTED_REFERENCES
  std::vector<hardware_interface::CommandInterface::SharedPtr> on_export_reference_interfaces_list()
  override
  {
    const std::string node = get_node()->get_name();  // the prefix that every distribution accepts
    references_.clear();
    for (const std::string & name : names_) {
      for (const std::string & kind : kinds_) {
        references_.push_back(
          std::make_shared<hardware_interface::CommandInterface>(node, name + "/" + kind));
      }
    }
    forget_references();
    return references_;
  }
#else
  std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() override
  {
    reference_interfaces_.assign(JOINTS * kinds_.size(), NONE);
    const std::string node = get_node()->get_name();  // the prefix that every distribution accepts
    std::vector<hardware_interface::CommandInterface> exported;
    double * value = reference_interfaces_.data();
    for (const std::string & name : names_) {
      for (const std::string & kind : kinds_) {
        exported.emplace_back(node, name + "/" + kind, value++);
      }
    }
    return exported;
  }
#endif

  bool on_set_chained_mode(bool) override
  {
    forget_references();
    return true;
  }

  // There is no topic for references: without a controller before this one, there are none.
#ifdef {{ name }}_TIMED_REFERENCES
  return_type update_reference_from_subscribers(
    const rclcpp::Time &, const rclcpp::Duration &) override
#else
  return_type update_reference_from_subscribers() override
#endif
  {
    return return_type::OK;
  }

  return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &) override
  {
    {{ name }}_warm();
    const Parameters & X = exchange_.read();
    Joints q;
    Joints qd{};
    Joints qdd{};
    Joints feedback{};
    Joints tau;
    for (std::size_t j = 0; j < JOINTS; ++j) {
      q[j] = Real(measure(2 * j));
    }
    if (full_) {
      for (std::size_t j = 0; j < JOINTS; ++j) {
        follow(j, q[j], qd[j], qdd[j], feedback[j]);
      }
    }
    // qd is the speed of the reference: measured noise at rest would make Coulomb friction chatter.
    {{ name }}_inverse_dynamics(q.data(), qd.data(), qdd.data(), X.data(){{ ", gravity_.data()" if gravity_input }}, tau.data());
    bool finite = true;
    for (std::size_t j = 0; j < JOINTS; ++j) {
      const double effort = reference(j, kinds_.size() - 1);
      tau[j] += feedback[j] + Real(std::isfinite(effort) ? effort : 0.0);
      finite = finite && std::isfinite(tau[j]);
    }
    send(finite ? tau : Joints{});
    return finite ? return_type::OK : return_type::ERROR;
  }

private:
  static std::vector<double> default_limits()
  {
{% if torque_limits %}
    return {std::begin({{ name }}_TORQUE_LIMITS), std::end({{ name }}_TORQUE_LIMITS)};
{% else %}
    return {};
{% endif %}
  }

  void declare()
  {
    auto_declare<std::string>("feedforward", "gravity");
    auto_declare<Names>("joints", joint_names());
    auto_declare<std::string>("prefix", "");
    auto_declare<std::vector<double>>("gains.p", {});
    auto_declare<std::vector<double>>("gains.d", {});
    auto_declare<std::vector<double>>("torque_limits", default_limits());
    auto_declare<std::vector<double>>("model.X", {});
    auto_declare<std::string>("model.digest", "");
{% if gravity_input %}
    auto_declare<std::vector<double>>("gravity", {DOWN.begin(), DOWN.end()});
{% endif %}
#ifndef {{ name }}_TIMED_REFERENCES
    auto_declare<std::string>("robot_description", "");
#endif
  }

  void send(const Joints & tau)
  {
    for (std::size_t j = 0; j < command_interfaces_.size(); ++j) {
      const Real sent = std::clamp(tau[j], -limits_[j], limits_[j]);
      static_cast<void>(command_interfaces_[j].set_value(double(sent)));
    }
  }

  /// Return a state, or where it is busy the one of the cycle before.
  double measure(std::size_t place)
  {
    measured_[place] = value_of(state_interfaces_[place], measured_[place], 0);
    return measured_[place];
  }

  InterfaceConfiguration interfaces(const Names & kinds) const
  {
    InterfaceConfiguration out;
    out.type = interface_configuration_type::INDIVIDUAL;
    for (const std::string & name : names_) {
      for (const std::string & kind : kinds) {
        out.names.push_back(name + "/" + kind);
      }
    }
    return out;
  }

  template <class Value>
  Value setting(const std::string & name) const
  {
    return get_node()->get_parameter(name).template get_value<Value>();
  }

  /// Read a list with a number for each joint, or without any take `otherwise`.
  std::string take_list(const std::string & name, double otherwise, Joints & out) const
  {
    const auto values = setting<std::vector<double>>(name);
    if (!values.empty() && values.size() != JOINTS) {
      return name + " has " + std::to_string(values.size()) + " numbers; the model has " +
             std::to_string(JOINTS) + " joints";
    }
    for (std::size_t j = 0; j < JOINTS; ++j) {
      out[j] = Real(values.empty() ? otherwise : values[j]);
      if (!(out[j] >= 0)) {
        return name + " must have numbers of at least 0";
      }
    }
    return "";
  }

  /// Read all parameters. Return why they are refused; "" if they are not.
  std::string take_settings()
  {
    const auto feedforward = setting<std::string>("feedforward");
    if (feedforward != "gravity" && feedforward != "full") {
      return "feedforward is '" + feedforward + "'; accepted: gravity, full";
    }
    full_ = feedforward == "full";
    kinds_ = full_ ? Names{"position", "velocity", "acceleration", "effort"} : Names{"effort"};
    names_ = setting<Names>("joints");
    prefix_ = setting<std::string>("prefix");
    const auto X = setting<std::vector<double>>("model.X");
    const double unlimited = std::numeric_limits<double>::infinity();
    const std::string reasons[] = {
      take_list("gains.p", 0.0, p_),
      take_list("gains.d", 0.0, d_),
      take_list("torque_limits", unlimited, limits_),
{% if gravity_input %}
      take_gravity(setting<std::vector<double>>("gravity"), gravity_),
{% endif %}
      take_parameters(X, setting<std::string>("model.digest"), X_),
      description_mismatch(),
    };
    for (const std::string & reason : reasons) {
      if (!reason.empty()) {
        return reason;
      }
    }
    if (full_ && !(*std::max_element(p_.begin(), p_.end()) > 0)) {
      return "feedforward full needs gains.p above 0: without feedback, no position is followed";
    }
    return "";
  }

  std::string description_mismatch() const
  {
#ifdef {{ name }}_TIMED_REFERENCES
    const std::string description = get_robot_description();
#else
    const std::string description = setting<std::string>("robot_description");
#endif
    if (description.empty()) {
      RCLCPP_WARN(get_node()->get_logger(),
        "no robot_description: the names of the joints are not checked");
    }
    return joint_mismatch(description, names_);
  }

  void take_load(const InertiaStamped & message)
  {
    const std::lock_guard<std::mutex> lock(configuring_);
    Parameters loaded = X_;
    const std::string reason = add_load(message, prefix_, loaded);
    if (!reason.empty()) {
      RCLCPP_ERROR(get_node()->get_logger(), "payload refused: %s", reason.c_str());
      return;
    }
    exchange_.write(loaded);
  }

  double reference(std::size_t joint, std::size_t kind) const
  {
    const std::size_t place = joint * kinds_.size() + kind;
#ifdef {{ name }}_LISTED_REFERENCES
    return place < references_.size() ? value_of(*references_[place], NONE, 0) : NONE;
#else
    return place < reference_interfaces_.size() ? reference_interfaces_[place] : NONE;
#endif
  }

  void forget_references()
  {
#ifdef {{ name }}_LISTED_REFERENCES
    for (const auto & one : references_) {
      static_cast<void>(one->set_value(NONE));
    }
#else
    std::fill(reference_interfaces_.begin(), reference_interfaces_.end(), NONE);
#endif
  }

  /// Set the speed, acceleration and feedback of a joint; without a reference, it holds its last
  /// position.
  void follow(std::size_t j, Real q, Real & qd, Real & qdd, Real & feedback)
  {
    const double position = reference(j, 0);
    if (std::isfinite(position)) {
      const double speed = reference(j, 1);
      const double acceleration = reference(j, 2);
      hold_[j] = Real(position);
      qd = Real(std::isfinite(speed) ? speed : 0.0);
      qdd = Real(std::isfinite(acceleration) ? acceleration : 0.0);
    } else if (!std::isfinite(hold_[j])) {
      hold_[j] = q;
    }
    feedback = p_[j] * (hold_[j] - q) + d_[j] * (qd - Real(measure(2 * j + 1)));
  }

  std::mutex configuring_;  // of settings and loads; a cycle does not take it
  bool full_ = false;
  std::string prefix_;
  Names names_;
  Names kinds_;
  Parameters X_{};
  Joints p_{};
  Joints d_{};
  Joints limits_{};
  Joints hold_{};
  std::array<double, 2 * JOINTS> measured_{};
{% if gravity_input %}
  Gravity gravity_ = DOWN;
{% endif %}
  Exchange<Parameters> exchange_;
  rclcpp::Subscription<InertiaStamped>::SharedPtr payload_;
#ifdef {{ name }}_LISTED_REFERENCES
  std::vector<hardware_interface::CommandInterface::SharedPtr> references_;
#endif
};
}  // namespace {{ package }}

PLUGINLIB_EXPORT_CLASS(
  {{ package }}::ModelController, controller_interface::ChainableControllerInterface)
