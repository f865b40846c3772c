#include "loops.hpp"

#include <pinocchio/algorithm/cholesky.hpp>
#include <pinocchio/algorithm/crba.hpp>

LOOP(mass_matrix, unused, n * n, {
    Eigen::Map<Rows>(to, n, n) = pinocchio::crba(model, *data, a);
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
