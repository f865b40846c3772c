#include "loops.hpp"

Model model;
Data *data;

extern "C" void begin() { model = Model(); }

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
    data = new Data(model);
}
