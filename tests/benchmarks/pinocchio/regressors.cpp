#include "loops.hpp"

#include <pinocchio/algorithm/regressor.hpp>

LOOP(energy_regressor, unused, 10 * n, {
    pinocchio::computeKineticEnergyRegressor(model, *data, a, b);
    pinocchio::computePotentialEnergyRegressor(model, *data, a);
    Eigen::Map<Vector>(to, 10 * n) = data->kineticEnergyRegressor + data->potentialEnergyRegressor;
})
LOOP(torque_regressor, qdd, 10 * n * n, {
    Eigen::Map<Rows>(to, n, 10 * n) = pinocchio::computeJointTorqueRegressor(model, *data, a, b, c);
})
