#include "loops.hpp"

#include <pinocchio/algorithm/aba.hpp>

LOOP(forward_dynamics, tau, n, {
    Eigen::Map<Vector>(to, n) = pinocchio::aba(model, *data, a, b, c);
})
