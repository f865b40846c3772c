#pragma once

#include <string>

namespace geometry_msgs::msg
{
struct InertiaStamped
{
  struct
  {
    std::string frame_id;
  } header;
  struct
  {
    double m = 0.0;
    struct
    {
      double x = 0.0, y = 0.0, z = 0.0;
    } com;
    double ixx = 0.0, ixy = 0.0, ixz = 0.0, iyy = 0.0, iyz = 0.0, izz = 0.0;
  } inertia;
};
}  // namespace geometry_msgs::msg
