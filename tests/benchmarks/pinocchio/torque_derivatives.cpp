#include "loops.hpp"

#include <pinocchio/algorithm/rnea-derivatives.hpp>

LOOP(inverse_dynamics_derivatives, qdd, 2 * n * n, {
    pinocchio::computeRNEADerivatives(model, *data, a, b, c);
    Eigen::Map<Rows>(to, n, n) = data->dtau_dq;
    Eigen::Map<Rows>(to + n * n, n, n) = data->dtau_dv;
})
