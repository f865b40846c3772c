// Signatures of controller_interface 2 (Humble), 4 (Jazzy) and 6 (Lyrical), from the headers of
// ros2_control and, for 6, its class pages and migration guide.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hardware_interface/handle.hpp"
#include "rclcpp_lifecycle/lifecycle_node.hpp"

namespace controller_interface
{
using CallbackReturn = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;

enum class return_type : std::uint8_t { OK = 0, ERROR = 1 };

enum class interface_configuration_type : std::uint8_t { ALL = 0, INDIVIDUAL = 1, NONE = 2 };

struct InterfaceConfiguration
{
  interface_configuration_type type;
  std::vector<std::string> names = {};
};

class ControllerInterfaceBase : public rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface
{
public:
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_init() = 0;
  virtual return_type update(const rclcpp::Time & time, const rclcpp::Duration & period) = 0;
  virtual bool set_chained_mode(bool chained_mode) = 0;

  void assign_interfaces(
    std::vector<hardware_interface::LoanedCommandInterface> && command_interfaces,
    std::vector<hardware_interface::LoanedStateInterface> && state_interfaces)
  {
    command_interfaces_ = std::move(command_interfaces);
    state_interfaces_ = std::move(state_interfaces);
  }

  /// Begin a node with these parameters, as `init` does.
  CallbackReturn begin(const std::string & name, const std::string & urdf, rclcpp::Values overrides)
  {
    node_ = std::make_shared<rclcpp_lifecycle::LifecycleNode>(name);
    node_->overrides = std::move(overrides);
    urdf_ = urdf;
    return on_init();
  }

  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const {return node_;}
#if DISTRIBUTION != HUMBLE
  const std::string & get_robot_description() const {return urdf_;}
#endif
  template <class Value>
  auto auto_declare(const std::string & name, const Value & default_value)
  {
    return node_->declare_parameter<Value>(name, default_value);
  }

protected:
  std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
  std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;

private:
  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_;
  std::string urdf_;
};

class ChainableControllerInterface : public ControllerInterfaceBase
{
public:
  return_type update(const rclcpp::Time & time, const rclcpp::Duration & period) final
  {
    if (!chained_) {
#if DISTRIBUTION == HUMBLE
      update_reference_from_subscribers();
#else
      update_reference_from_subscribers(time, period);
#endif
    }
    return update_and_write_commands(time, period);
  }

  bool set_chained_mode(bool chained_mode) final
  {
    chained_ = chained_mode;
    return on_set_chained_mode(chained_mode);
  }

  /// Humble and early Jazzy want the name of the node as the prefix, later ones one that begins so.
  std::vector<hardware_interface::CommandInterface::SharedPtr> export_reference_interfaces()
  {
    std::vector<hardware_interface::CommandInterface::SharedPtr> out;
#if DISTRIBUTION == LYRICAL
    out = on_export_reference_interfaces_list();
#else
    for (auto & one : on_export_reference_interfaces()) {
      out.push_back(std::make_shared<hardware_interface::CommandInterface>(std::move(one)));
    }
#endif
    for (const auto & one : out) {
      if (one->get_prefix_name() != get_node()->get_name()) {
        throw std::runtime_error("the prefix of a reference is not the name of the node");
      }
    }
    return out;
  }

protected:
#if DISTRIBUTION == LYRICAL
  virtual std::vector<hardware_interface::CommandInterface::SharedPtr>
  on_export_reference_interfaces_list() = 0;
#else
  virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() = 0;
#endif
  virtual bool on_set_chained_mode(bool) {return true;}
#if DISTRIBUTION == HUMBLE
  virtual return_type update_reference_from_subscribers() = 0;
#else
  virtual return_type update_reference_from_subscribers(
    const rclcpp::Time & time, const rclcpp::Duration & period) = 0;
#endif
  virtual return_type update_and_write_commands(
    const rclcpp::Time & time, const rclcpp::Duration & period) = 0;
  std::vector<double> reference_interfaces_;

private:
  bool chained_ = false;
};
}  // namespace controller_interface
