#include "loops.hpp"

#include <pinocchio/algorithm/energy.hpp>
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/kinematics.hpp>

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
