#pragma once

#include "rclcpp/rclcpp.hpp"

namespace inverse_dynamics_solver
{
typedef rclcpp::exceptions::InvalidParameterValueException InvalidParameterValueException;

class UninitializedException : public std::runtime_error
{
public:
  UninitializedException() : std::runtime_error("no initialize") {}
};
}  // namespace inverse_dynamics_solver
