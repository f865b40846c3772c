#include "loops.hpp"

#include <pinocchio/algorithm/rnea.hpp>

LOOP(inverse_dynamics, qdd, n, {
    Eigen::Map<Vector>(to, n) = pinocchio::rnea(model, *data, a, b, c);
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
