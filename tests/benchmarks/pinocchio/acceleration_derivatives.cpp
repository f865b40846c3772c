#include "loops.hpp"

#include <pinocchio/algorithm/aba-derivatives.hpp>

LOOP(forward_dynamics_derivatives, tau, 3 * n * n, {
    pinocchio::computeABADerivatives(model, *data, a, b, c);
    Eigen::Map<Rows>(to, n, n) = data->ddq_dq;
    Eigen::Map<Rows>(to + n * n, n, n) = data->ddq_dv;
    Eigen::Map<Rows>(to + 2 * n * n, n, n) = data->Minv;
})
