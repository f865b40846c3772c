// DISTRIBUTION is one of these. Versions: Humble has rclcpp 16, ros2_control 2 and
// kinematics_interface 0; Jazzy 28, 4 and 1; Lyrical ros2_control 6.
#pragma once
#define HUMBLE 1
#define JAZZY 2
#define LYRICAL 3
#if DISTRIBUTION == HUMBLE
#define RCLCPP_VERSION_MAJOR 16
#elif DISTRIBUTION == JAZZY
#define RCLCPP_VERSION_MAJOR 28
#else
#define RCLCPP_VERSION_MAJOR 30
#endif
