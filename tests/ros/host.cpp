// Loads the plugins of a package by their names, and calls them for Python.
#include <class_loader/class_loader.hpp>

#include <cstring>

#include <controller_interface/chainable_controller_interface.hpp>
#include <geometry_msgs/msg/inertia_stamped.hpp>
#include <inverse_dynamics_solver/inverse_dynamics_solver.hpp>
#include <kinematics_interface/kinematics_interface.hpp>

using controller_interface::CallbackReturn;
using controller_interface::ChainableControllerInterface;
using hardware_interface::CommandInterface;
using hardware_interface::StateInterface;
using inverse_dynamics_solver::InverseDynamicsSolver;
using kinematics_interface::KinematicsInterface;
using Message = geometry_msgs::msg::InertiaStamped;
using Vector = Eigen::VectorXd;

struct Host
{
  std::unique_ptr<class_loader::ClassLoader> loader;
  rclcpp::Values parameters;
  std::shared_ptr<ChainableControllerInterface> controller;
  std::vector<double> state;
  std::vector<double> command;
  std::vector<std::string> names[3];  // of commands, states and references
  std::vector<CommandInterface::SharedPtr> commands;
  std::vector<StateInterface::SharedPtr> states;
  std::vector<CommandInterface::SharedPtr> references;
  std::shared_ptr<InverseDynamicsSolver> solver;
  std::shared_ptr<KinematicsInterface> kinematics;
};

namespace
{
template <class Handle>
std::shared_ptr<Handle> handle(const std::string & name, double * value)
{
  const auto slash = name.rfind('/');
#if DISTRIBUTION == LYRICAL
  static_cast<void>(value);
  return std::make_shared<Handle>(name.substr(0, slash), name.substr(slash + 1));
#else
  return std::make_shared<Handle>(name.substr(0, slash), name.substr(slash + 1), value);
#endif
}

double get(const CommandInterface & one)
{
#if DISTRIBUTION == HUMBLE
  return one.get_value();
#else
  return one.get_optional().value();
#endif
}

template <class Handle>
void set(Handle & one, double value)
{
  static_cast<void>(one.set_value(value));
}

/// Run a call, and put the message of an exception into the log.
template <class Call>
int guarded(Call call)
{
  try {
    return call() ? 0 : 1;
  } catch (const std::exception & error) {
    rclcpp::last_log() = error.what();
    return 2;
  }
}

Eigen::Map<const Vector> mapped(const double * values, int n)
{
  return {values, n};
}
}  // namespace

extern "C" {
const char * last_log() {return rclcpp::last_log().c_str();}

Host * open_host(const char * library)
{
  auto host = std::make_unique<Host>();
  host->loader = std::make_unique<class_loader::ClassLoader>(library);
  return host.release();
}

void close_host(Host * host)
{
  host->controller.reset();
  host->solver.reset();
  host->kinematics.reset();
  delete host;
}

void set_text(Host * host, const char * name, const char * text)
{
  host->parameters[name] = std::string(text);
}

void set_flag(Host * host, const char * name, int value) {host->parameters[name] = value != 0;}

void set_numbers(Host * host, const char * name, const double * values, int count)
{
  host->parameters[name] = std::vector<double>(values, values + count);
}

void set_integers(Host * host, const char * name, const double * values, int count)
{
  host->parameters[name] = std::vector<std::int64_t>(values, values + count);
}

/// Set names, separated by commas.
void set_names(Host * host, const char * name, const char * text)
{
  std::vector<std::string> names{""};
  for (const char c : std::string(text)) {
    if (c == ',') {
      names.emplace_back();
    } else {
      names.back() += c;
    }
  }
  host->parameters[name] = names;
}

/// Load, configure and activate a controller.
int start_controller(Host * host, const char * type, const char * urdf)
{
  rclcpp::last_log().clear();
  return guarded([&] {
    const auto made = host->loader->createInstance<ChainableControllerInterface>(type);
    host->controller = made;
    const auto done = CallbackReturn::SUCCESS;
    if (made->begin("arm", urdf, host->parameters) != done || made->on_configure({}) != done) {
      return false;
    }
    host->references = made->export_reference_interfaces();
    host->names[0] = made->command_interface_configuration().names;
    host->names[1] = made->state_interface_configuration().names;
    host->command.assign(host->names[0].size(), 0.0);
    host->state.assign(host->names[1].size(), 0.0);
    std::vector<hardware_interface::LoanedCommandInterface> commands;
    std::vector<hardware_interface::LoanedStateInterface> states;
    host->commands.clear();
    host->states.clear();
    for (std::size_t i = 0; i < host->command.size(); ++i) {
      host->commands.push_back(handle<CommandInterface>(host->names[0][i], &host->command[i]));
      commands.emplace_back(host->commands.back());
    }
    for (std::size_t i = 0; i < host->state.size(); ++i) {
      host->states.push_back(handle<StateInterface>(host->names[1][i], &host->state[i]));
      states.emplace_back(host->states.back());
    }
    host->names[2].clear();
    for (const auto & one : host->references) {
      host->names[2].push_back(one->get_name());
    }
    made->assign_interfaces(std::move(commands), std::move(states));
    return made->on_activate({}) == done;
  });
}

const char * interface_names(Host * host, int kind)
{
  static std::string text;
  text.clear();
  for (const std::string & name : host->names[kind]) {
    text += (text.empty() ? "" : ",") + name;
  }
  return text.c_str();
}

/// Switch the mode as a controller manager does, which refuses it while the controller is active.
void chain(Host * host, int chained)
{
  host->controller->on_deactivate({});
  host->controller->set_chained_mode(chained != 0);
  host->controller->on_activate({});
}

void deactivate(Host * host) {host->controller->on_deactivate({});}

void get_commands(Host * host, double * command)
{
  for (std::size_t i = 0; i < host->commands.size(); ++i) {
    command[i] = get(*host->commands[i]);
  }
}

void set_references(Host * host, const double * values)
{
  for (std::size_t i = 0; i < host->references.size(); ++i) {
    set(*host->references[i], values[i]);
  }
}

/// One cycle: the state in the order of the state interfaces.
int cycle(Host * host, const double * state)
{
  for (std::size_t i = 0; i < host->states.size(); ++i) {
    set(*host->states[i], state[i]);
  }
  return static_cast<int>(host->controller->update(rclcpp::Time(), rclcpp::Duration()));
}

/// Publish a load: mass, centre of mass (3), inertia xx xy xz yy yz zz.
void publish_load(Host * host, const char * frame, const double * body)
{
  Message message;
  message.header.frame_id = frame;
  auto & inertia = message.inertia;
  inertia.m = body[0];
  inertia.com.x = body[1];
  inertia.com.y = body[2];
  inertia.com.z = body[3];
  double * const entries[] = {&inertia.ixx, &inertia.ixy, &inertia.ixz,
    &inertia.iyy, &inertia.iyz, &inertia.izz};
  for (int i = 0; i < 6; ++i) {
    *entries[i] = body[4 + i];
  }
  rclcpp::last_log().clear();
  const auto node = host->controller->get_node();
  const auto topic = std::static_pointer_cast<rclcpp::Subscription<Message>>(node->subscription);
  topic->callback(std::make_shared<const Message>(message));
}

int start_solver(Host * host, const char * type, const char * urdf)
{
  return guarded([&] {
    host->solver = host->loader->createInstance<InverseDynamicsSolver>(type);
    auto parameters = std::make_shared<rclcpp::node_interfaces::NodeParametersInterface>();
    parameters->values = host->parameters;
    host->solver->initialize(parameters, "", urdf);
    return true;
  });
}

/// Inertia matrix (n, n), Coriolis, gravity, friction, and torques (n,).
int solve(
  Host * host, int n, const double * q, const double * qd, const double * qdd, double * M,
  double * C, double * g, double * friction, double * tau)
{
  return guarded([&] {
    const Vector p = mapped(q, n);
    const Vector v = mapped(qd, n);
    const auto [inertia, coriolis, gravity] = host->solver->getDynamicParameters(p, v);
    Eigen::MatrixXd::Map(M, n, n) = inertia;
    Vector::Map(C, n) = coriolis;
    Vector::Map(g, n) = gravity;
    Vector::Map(friction, n) = host->solver->getFrictionVector(v);
    Vector::Map(tau, n) = host->solver->getTorques(p, v, mapped(qdd, n));
    return true;
  });
}

/// Seconds of `repeats` calls of getTorques (0) or getInertiaMatrix (1).
double time_solver(
  Host * host, int n, const double * q, const double * qd, const double * qdd, int which,
  int repeats)
{
  const Vector p = mapped(q, n);
  const Vector v = mapped(qd, n);
  const Vector a = mapped(qdd, n);
  double sum = 0.0;
  timespec begin, end;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
  for (int i = 0; i < repeats; ++i) {
    sum += which == 0 ? host->solver->getTorques(p, v, a)[0] : host->solver->getInertiaMatrix(p)(0);
  }
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
  const double seconds =
    static_cast<double>(end.tv_sec - begin.tv_sec) + 1e-9 * static_cast<double>(end.tv_nsec - begin.tv_nsec);
  return sum < 1e300 ? seconds : -1.0;
}

int start_kinematics(Host * host, const char * type, const char * urdf)
{
  rclcpp::last_log().clear();
  return guarded([&] {
    host->kinematics = host->loader->createInstance<KinematicsInterface>(type);
    auto parameters = std::make_shared<rclcpp::node_interfaces::NodeParametersInterface>();
    parameters->values = host->parameters;
#if DISTRIBUTION == HUMBLE
    parameters->values["robot_description"] = std::string(urdf);
    return host->kinematics->initialize(parameters, "tool");
#else
    return host->kinematics->initialize(urdf, parameters, "");
#endif
  });
}

/// Pose (4, 4), Jacobian (6, n) and its inverse (n, 6, zero in Humble) of a link; column-major.
int locate(Host * host, int n, const double * q, const char * link, double * T, double * J, double * inverse)
{
  return guarded([&] {
    const Vector p = mapped(q, n);
    Eigen::Isometry3d pose;
    Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(6, n);
    Eigen::Matrix<double, Eigen::Dynamic, 6> back = Eigen::Matrix<double, Eigen::Dynamic, 6>::Zero(n, 6);
    if (!host->kinematics->calculate_link_transform(p, link, pose) ||
      !host->kinematics->calculate_jacobian(p, link, jacobian))
    {
      return false;
    }
#if DISTRIBUTION != HUMBLE
    if (!host->kinematics->calculate_jacobian_inverse(p, link, back)) {
      return false;
    }
#endif
    Eigen::Matrix4d::Map(T) = pose.matrix();
    Eigen::MatrixXd::Map(J, 6, n) = jacobian;
    Eigen::MatrixXd::Map(inverse, n, 6) = back;
    return true;
  });
}
}
