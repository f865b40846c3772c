#pragma once

#include "rclcpp/rclcpp.hpp"

namespace rclcpp_lifecycle
{
class State {};

namespace node_interfaces
{
class LifecycleNodeInterface
{
public:
  enum class CallbackReturn : unsigned char { SUCCESS = 97, FAILURE = 98, ERROR = 99 };
  virtual ~LifecycleNodeInterface() = default;
  virtual CallbackReturn on_configure(const State &) {return CallbackReturn::SUCCESS;}
  virtual CallbackReturn on_cleanup(const State &) {return CallbackReturn::SUCCESS;}
  virtual CallbackReturn on_shutdown(const State &) {return CallbackReturn::SUCCESS;}
  virtual CallbackReturn on_activate(const State &) {return CallbackReturn::SUCCESS;}
  virtual CallbackReturn on_deactivate(const State &) {return CallbackReturn::SUCCESS;}
  virtual CallbackReturn on_error(const State &) {return CallbackReturn::SUCCESS;}
};
}  // namespace node_interfaces

class LifecycleNode
{
public:
  explicit LifecycleNode(std::string name) : name_(std::move(name)) {}
  const char * get_name() const {return name_.c_str();}
  rclcpp::Logger get_logger() const {return {};}
  bool has_parameter(const std::string & name) const {return values.count(name) != 0;}
  rclcpp::Parameter get_parameter(const std::string & name) const
  {
    return {name, values.at(name)};
  }
  template <class Value>
  Value declare_parameter(const std::string & name, const Value & default_value)
  {
    const auto given = overrides.find(name);
    values[name] = given == overrides.end() ? rclcpp::ParameterValue(default_value) : given->second;
    return std::get<Value>(values[name]);
  }
  template <class Message, class Callback>
  std::shared_ptr<rclcpp::Subscription<Message>> create_subscription(
    const std::string & topic, const rclcpp::QoS &, Callback && callback)
  {
    auto made = std::make_shared<rclcpp::Subscription<Message>>();
    made->topic = topic;
    made->callback = callback;
    subscription = made;
    return made;
  }
  rclcpp::Values overrides;
  rclcpp::Values values;
  std::shared_ptr<void> subscription;

private:
  std::string name_;
};
}  // namespace rclcpp_lifecycle
