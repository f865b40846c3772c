// Pinocchio's algorithms in a C++ loop over samples, outputs stored: all templates compiled here.
#include <cstddef>
#include <pinocchio/multibody.hpp>

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/cholesky.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/energy.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

using Vector = Eigen::VectorXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
static pinocchio::Model model;
static pinocchio::Data *data;

extern "C" void begin() { model = pinocchio::Model(); }

extern "C" void joint(std::size_t parent, const double *R, const double *p, const double *body)
{
    const Eigen::Matrix3d rotation
        = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R);
    const Eigen::Vector3d translation = Eigen::Map<const Eigen::Vector3d>(p);
    const auto id = model.addJoint(parent, pinocchio::JointModelRZ(),
        pinocchio::SE3(rotation, translation), std::to_string(model.njoints));
    const Eigen::Matrix<double, 10, 1> inertia
        = Eigen::Map<const Eigen::Matrix<double, 10, 1>>(body);
    model.appendBodyToJoint(
        id, pinocchio::Inertia::FromDynamicParameters(inertia), pinocchio::SE3::Identity());
    model.addJointFrame(id);
}

extern "C" void end(const double *g)
{
    model.gravity.linear(Eigen::Map<const Eigen::Vector3d>(g));
    delete data;
    data = new pinocchio::Data(model);
}

#define LOOP(name, third, size, ...)                                                               \
    extern "C" void name(std::size_t N, const double *q, const double *qd, const double *third,    \
        double *out)                                                                               \
    {                                                                                              \
        const auto n = model.nv;                                                                   \
        const std::size_t count = size;                                                            \
        Vector a(n), b(n), c(n);                                                                   \
        for (std::size_t k = 0; k < N; ++k) {                                                      \
            a = Eigen::Map<const Vector>(q + k * n, n);                                            \
            b = Eigen::Map<const Vector>(qd + k * n, n);                                           \
            c = Eigen::Map<const Vector>(third + k * n, n);                                        \
            double *to = out + k * count;                                                          \
            __VA_ARGS__                                                                            \
        }                                                                                          \
    }

LOOP(energy_regressor, unused, 10 * n, {
    pinocchio::computeKineticEnergyRegressor(model, *data, a, b);
    pinocchio::computePotentialEnergyRegressor(model, *data, a);
    Eigen::Map<Vector>(to, 10 * n) = data->kineticEnergyRegressor + data->potentialEnergyRegressor;
})
LOOP(torque_regressor, qdd, 10 * n * n, {
    Eigen::Map<Rows>(to, n, 10 * n) = pinocchio::computeJointTorqueRegressor(model, *data, a, b, c);
})
LOOP(inverse_dynamics, qdd, n, {
    Eigen::Map<Vector>(to, n) = pinocchio::rnea(model, *data, a, b, c);
})
LOOP(mass_matrix, unused, n * n, {
    Eigen::Map<Rows>(to, n, n) = pinocchio::crba(model, *data, a);
})
LOOP(forward_dynamics, tau, n, {
    Eigen::Map<Vector>(to, n) = pinocchio::aba(model, *data, a, b, c);
})
LOOP(gravity_torque, unused, n, {
    Eigen::Map<Vector>(to, n) = pinocchio::computeGeneralizedGravity(model, *data, a);
})
LOOP(coriolis, unused, n * n, {
    Eigen::Map<Rows>(to, n, n) = pinocchio::computeCoriolisMatrix(model, *data, a, b);
})
LOOP(bias_torque, unused, n, {
    Eigen::Map<Vector>(to, n) = pinocchio::nonLinearEffects(model, *data, a, b);
})
LOOP(energy, unused, 2, {
    to[0] = pinocchio::computeKineticEnergy(model, *data, a, b);
    to[1] = pinocchio::computePotentialEnergy(model, *data, a);
})
LOOP(frames, unused, 16 * n, {
    pinocchio::forwardKinematics(model, *data, a);
    for (int j = 0; j < n; ++j) {
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(to + 16 * j)
            = data->oMi[j + 1].toHomogeneousMatrix();
    }
})
LOOP(jacobian, unused, 6 * n, {
    Eigen::Matrix<double, 6, Eigen::Dynamic> J = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, n);
    pinocchio::computeFrameJacobian(
        model, *data, a, model.nframes - 1, pinocchio::LOCAL_WORLD_ALIGNED, J);
    Eigen::Map<Rows>(to, 6, n) = J;
})
LOOP(inverse_dynamics_derivatives, qdd, 2 * n * n, {
    pinocchio::computeRNEADerivatives(model, *data, a, b, c);
    Eigen::Map<Rows>(to, n, n) = data->dtau_dq;
    Eigen::Map<Rows>(to + n * n, n, n) = data->dtau_dv;
})
LOOP(forward_dynamics_derivatives, tau, 3 * n * n, {
    pinocchio::computeABADerivatives(model, *data, a, b, c);
    Eigen::Map<Rows>(to, n, n) = data->ddq_dq;
    Eigen::Map<Rows>(to + n * n, n, n) = data->ddq_dv;
    Eigen::Map<Rows>(to + 2 * n * n, n, n) = data->Minv;
})
LOOP(solve_mass_matrix, b_, n, {
    pinocchio::crba(model, *data, a);
    pinocchio::cholesky::decompose(model, *data);
    pinocchio::cholesky::solve(model, *data, c);
    Eigen::Map<Vector>(to, n) = c;
})
LOOP(mass_matrix_factor, unused, n * n + n, {
    pinocchio::crba(model, *data, a);
    pinocchio::cholesky::decompose(model, *data);
    Eigen::Map<Rows>(to, n, n) = data->U;
    Eigen::Map<Vector>(to + n * n, n) = data->D;
})
