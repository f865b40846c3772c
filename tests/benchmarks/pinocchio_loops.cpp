// Pinocchio's algorithms in a C++ loop over samples, outputs stored: all templates compiled here.
#include <cstddef>
#include <pinocchio/multibody.hpp>

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/regressor.hpp>
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
}

extern "C" void end(const double *g)
{
    model.gravity.linear(Eigen::Map<const Eigen::Vector3d>(g));
    delete data;
    data = new pinocchio::Data(model);
}

#define LOOP(name, third, size, body)                                                              \
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
            body                                                                                   \
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
