// {{ robot }}: names, parameters and links that the plugins of {{ package }} share.
#pragma once

#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "{{ name }}.h"
{% if links_header %}
#include "{{ name }}_links.h"
{% endif %}
{% if limits_header %}
#include "{{ name }}_limits.h"
{% endif %}
{% if known %}
#include "{{ name }}_values.h"
{% endif %}

namespace {{ package }}
{
using Real = {{ name }}_real;
constexpr std::size_t JOINTS = {{ name }}_JOINTS;
constexpr std::size_t PARAMETERS = {{ name }}_PARAMETERS;
using Joints = std::array<Real, JOINTS>;
using Parameters = std::array<Real, PARAMETERS>;
using Names = std::vector<std::string>;
{% if gravity_input %}

/// Gravity in frame 0 of the model, m/s2: parameter `gravity`.
using Gravity = std::array<Real, 3>;
constexpr Gravity DOWN{0, 0, Real(-9.81)};
{% endif %}

/// Names of the joints, in the order of q.
inline Names joint_names()
{
  return {
{% for joint in joints %}
    {{ joint }},
{% endfor %}
  };
}

/// A link of the robot file: its name, the number of its joint (0: base), and its frame in that of
/// the joint, 4 x 4 and row-major.
struct Link
{
  const char * name;
  std::size_t joint;
  const Real * frame;
};

/// The transform of a frame that is that of its joint.
constexpr Real SAME[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

inline const std::vector<Link> & links()
{
  static const std::vector<Link> known = {
{% for link in links %}
    {{ "{" }}{{ link.text }}, {{ link.joint }}, {{ link.frame }}{{ "}" }},
{% endfor %}
  };
  return known;
}

/// Return the link of a name that begins with a prefix; nullptr without one.
inline const Link * find_link(const std::string & name, const std::string & prefix)
{
  for (const Link & link : links()) {
    if (name == prefix + link.name) {
      return &link;
    }
  }
  return nullptr;
}

inline std::string listed(const Names & names)
{
  std::string text;
  for (const std::string & name : names) {
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

inline std::string listed_links()
{
  Names names;
  for (const Link & link : links()) {
    names.emplace_back(link.name);
  }
  return listed(names);
}

/// Return why these joints do not belong to the model or to a robot description, if there is one;
/// "" if they do.
inline std::string joint_mismatch(const std::string & description, const Names & names)
{
  if (names.size() != JOINTS) {
    return "joints has " + std::to_string(names.size()) + " names; the model has " +
           std::to_string(JOINTS) + ": " + listed(joint_names());
  }
  if (description.empty()) {
    return "";
  }
  const auto robot = urdf::parseURDF(description);
  if (!robot) {
    return "robot_description is not a URDF";
  }
  Names movable;
  for (const auto & entry : robot->joints_) {
    if (entry.second->type != urdf::Joint::FIXED) {
      movable.push_back(entry.first);
    }
  }
  for (const std::string & name : names) {
    if (std::find(movable.begin(), movable.end(), name) == movable.end()) {
      return "joint " + name + " is not in robot_description; joints of the model: " +
             listed(names) + "; joints of robot_description: " + listed(movable);
    }
  }
  return "";
}

inline std::string model_digest()
{
  char text[32];
  std::snprintf(text, sizeof text, "sha256:%016llx",
    static_cast<unsigned long long>({{ name }}_MODEL_DIGEST));
  return text;
}

{% if gravity_input %}
/// Take the parameter `gravity` of the node. Return why it is refused; "" if it is taken.
inline std::string take_gravity(const std::vector<double> & values, Gravity & gravity)
{
  if (values.size() != gravity.size()) {
    return "gravity has " + std::to_string(values.size()) + " numbers; accepted: 3, in m/s2";
  }
  std::copy_n(values.begin(), gravity.size(), gravity.begin());
  return "";
}

{% endif %}
/// Take the parameters X of the node, or without any those of {{ name }}_values.h. Return why they
/// are refused; "" if they are taken.
inline std::string take_parameters(
  const std::vector<double> & values, const std::string & digest, Parameters & X)
{
  if (!digest.empty() && digest != model_digest()) {
    return "model.digest is " + digest + "; the model of this package has " + model_digest();
  }
  if (values.empty()) {
{% if known %}
    std::copy_n({{ name }}_values, PARAMETERS, X.begin());
    return "";
{% else %}
    return "the package has no values: set model.X, or generate the package with --parameters";
{% endif %}
  }
  if (values.size() != PARAMETERS) {
    return "model.X has " + std::to_string(values.size()) + " numbers; the model has " +
           std::to_string(PARAMETERS);
  }
  for (std::size_t i = 0; i < PARAMETERS; ++i) {
    if (!std::isfinite(values[i])) {
      return "model.X[" + std::to_string(i) + "] is not finite";
    }
    X[i] = static_cast<Real>(values[i]);
  }
  return "";
}

/// Hands values from one writing thread to one reading thread, without a lock: three places, of
/// which the middle one changes hands.
template <class Value>
class Exchange
{
public:
  /// Set all places. Neither thread may be running.
  void reset(const Value & value)
  {
    places_.fill(value);
  }

  void write(const Value & value)
  {
    places_[back_] = value;
    back_ = middle_.exchange(back_ | NEW, std::memory_order_acq_rel) & PLACE;
  }

  /// Return the newest complete value.
  const Value & read()
  {
    if ((middle_.load(std::memory_order_relaxed) & NEW) != 0u) {
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & PLACE;
    }
    return places_[front_];
  }

private:
  static constexpr unsigned PLACE = 3u;
  static constexpr unsigned NEW = 4u;
  std::array<Value, 3> places_{};
  std::atomic<unsigned> middle_{1u};
  unsigned back_ = 0u;
  unsigned front_ = 2u;
};
}  // namespace {{ package }}
