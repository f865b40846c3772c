// Handles: until Humble a pointer to a double; with get_optional in Jazzy (hardware_interface 4.27);
// in Lyrical with a value of their own, and the pointer deprecated.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "rclcpp/version.h"

namespace hardware_interface
{
class Handle
{
public:
#if DISTRIBUTION == LYRICAL
  Handle(
    const std::string & prefix, const std::string & interface,
    const std::string & = "double", const std::string & = "")
  : prefix_(prefix), interface_(interface), value_(&own_) {}
  [[deprecated]]
#endif
  Handle(const std::string & prefix, const std::string & interface, double * value)
  : prefix_(prefix), interface_(interface), value_(value) {}
  std::string get_name() const {return prefix_ + "/" + interface_;}
  const std::string & get_prefix_name() const {return prefix_;}
#if DISTRIBUTION == HUMBLE
  double get_value() const {return *value_;}
  void set_value(double value) {*value_ = value;}
#else
  [[deprecated]] double get_value() const {return *value_;}
  template <class Value = double>
  [[nodiscard]] std::optional<Value> get_optional() const {return *value_;}
  template <class Value>
  [[nodiscard]] bool set_value(const Value & value)
  {
    *value_ = value;
    return true;
  }
#endif

private:
  std::string prefix_;
  std::string interface_;
  double own_ = std::numeric_limits<double>::quiet_NaN();
  double * value_;
};

class StateInterface : public Handle
{
public:
  using SharedPtr = std::shared_ptr<StateInterface>;
  using Handle::Handle;
};

class CommandInterface : public Handle
{
public:
  using SharedPtr = std::shared_ptr<CommandInterface>;
  using Handle::Handle;
  CommandInterface(const CommandInterface &) = delete;
#if DISTRIBUTION != LYRICAL
  CommandInterface(CommandInterface &&) = default;
#endif
};

/// What a controller is lent: it works like the handle.
template <class Lent>
class Loaned
{
public:
  explicit Loaned(std::shared_ptr<Lent> lent) : lent_(std::move(lent)) {}
#if DISTRIBUTION == HUMBLE
  double get_value() const {return lent_->get_value();}
  void set_value(double value) {lent_->set_value(value);}
#else
  template <class Value = double>
  [[nodiscard]] std::optional<Value> get_optional(unsigned int = 10) const
  {
    return lent_->template get_optional<Value>();
  }
  template <class Value>
  [[nodiscard]] bool set_value(const Value & value, unsigned int = 10)
  {
    return lent_->set_value(value);
  }
#endif

private:
  std::shared_ptr<Lent> lent_;
};

using LoanedStateInterface = Loaned<StateInterface>;
using LoanedCommandInterface = Loaned<CommandInterface>;
}  // namespace hardware_interface
