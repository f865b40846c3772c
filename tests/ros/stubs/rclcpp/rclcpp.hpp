// What the plugins use of rclcpp, with its signatures; parameters, messages and logs stay in memory.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "rclcpp/version.h"

namespace rclcpp
{
class Time {};
class Duration {};
class NodeOptions {};

class QoS
{
public:
  explicit QoS(std::size_t) {}
};

class Logger {};

inline Logger get_logger(const std::string &) {return {};}

/// The last message of the log.
inline std::string & last_log()
{
  static std::string text;
  return text;
}

using ParameterValue = std::variant<
  std::monostate, bool, double, std::string, std::vector<double>, std::vector<std::string>,
  std::vector<std::int64_t>>;

class Parameter
{
public:
  Parameter() = default;
  Parameter(const std::string &, ParameterValue value) : value_(std::move(value)) {}
  bool as_bool() const {return std::get<bool>(value_);}
  double as_double() const {return std::get<double>(value_);}
  const std::string & as_string() const {return std::get<std::string>(value_);}
  const std::vector<double> & as_double_array() const
  {
    return std::get<std::vector<double>>(value_);
  }
  const std::vector<std::string> & as_string_array() const
  {
    return std::get<std::vector<std::string>>(value_);
  }
  template <class Value>
  Value get_value() const {return std::get<Value>(value_);}

private:
  ParameterValue value_;
};

using Values = std::map<std::string, ParameterValue>;

template <class Message>
class Subscription
{
public:
  using SharedPtr = std::shared_ptr<Subscription>;
  std::string topic;
  std::function<void (std::shared_ptr<const Message>)> callback;
};

namespace exceptions
{
class InvalidParameterValueException : public std::runtime_error
{
  using std::runtime_error::runtime_error;
};
}  // namespace exceptions

namespace node_interfaces
{
class NodeParametersInterface
{
public:
  using ConstSharedPtr = std::shared_ptr<const NodeParametersInterface>;
  virtual ~NodeParametersInterface() = default;
  bool get_parameter(const std::string & name, Parameter & parameter) const
  {
    const auto found = values.find(name);
    if (found != values.end()) {
      parameter = Parameter(name, found->second);
    }
    return found != values.end();
  }
  Values values;
};
}  // namespace node_interfaces
}  // namespace rclcpp

#define RCLCPP_LOG(...) \
  do { \
    char text[4096]; \
    std::snprintf(text, sizeof text, __VA_ARGS__); \
    rclcpp::last_log() = text; \
  } while (false)
#define RCLCPP_ERROR(logger, ...) (static_cast<void>(logger), [&] {RCLCPP_LOG(__VA_ARGS__);}())
#define RCLCPP_WARN(logger, ...) RCLCPP_ERROR(logger, __VA_ARGS__)
