// Three of Pinocchio's algorithms on a free flyer with revolute joints, over rows of n + 6 numbers:
// q; qd and w; the third, qdd or tau, with f and wd or the wrench. `place` is each joint's v in it.
#define BOOST_VARIANT_USE_RELAXED_GET_BY_DEFAULT
#include <cstddef>
#include <vector>
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

template<typename S, int O>
struct LegJoints {
    using Scalar = S;
    static constexpr int Options = O;
    using JointModelRX = pinocchio::JointModelRevoluteTpl<S, O, 0>;
    using JointModelRY = pinocchio::JointModelRevoluteTpl<S, O, 1>;
    using JointModelRZ = pinocchio::JointModelRevoluteTpl<S, O, 2>;
    using JointModelAny = pinocchio::JointModelRevoluteUnalignedTpl<S, O>;
    using JointModelFree = pinocchio::JointModelFreeFlyerTpl<S, O>;
    using JointModelVariant = boost::variant<JointModelRX, JointModelRY, JointModelRZ,
        JointModelAny, JointModelFree>;
    using JointDataRX = pinocchio::JointDataRevoluteTpl<S, O, 0>;
    using JointDataRY = pinocchio::JointDataRevoluteTpl<S, O, 1>;
    using JointDataRZ = pinocchio::JointDataRevoluteTpl<S, O, 2>;
    using JointDataAny = pinocchio::JointDataRevoluteUnalignedTpl<S, O>;
    using JointDataFree = pinocchio::JointDataFreeFlyerTpl<S, O>;
    using JointDataVariant
        = boost::variant<JointDataRX, JointDataRY, JointDataRZ, JointDataAny, JointDataFree>;
};
using Model = pinocchio::ModelTpl<double, 0, LegJoints>;
using Data = pinocchio::DataTpl<double, 0, LegJoints>;
using Vector = Eigen::VectorXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
static Model model;
static Data *data;
static std::vector<int> place;
static Vector q_, v_, a_;

extern "C" void begin(const double *body)
{
    model = Model();
    model.addJoint(0, pinocchio::JointModelFreeFlyerTpl<double, 0>(), pinocchio::SE3::Identity(), "0");
    model.inertias[1] = pinocchio::Inertia::FromDynamicParameters(
        Eigen::Map<const Eigen::Matrix<double, 10, 1>>(body));
}

extern "C" void joint(
    std::size_t parent, const double *axis, const double *R, const double *p, const double *body)
{
    const Eigen::Matrix3d rotation
        = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R);
    const Eigen::Vector3d translation = Eigen::Map<const Eigen::Vector3d>(p);
    const pinocchio::SE3 at(rotation, translation);
    const auto name = std::to_string(model.njoints);
    const Eigen::Vector3d e = Eigen::Map<const Eigen::Vector3d>(axis);
    const auto id = e[0] == 1 ? model.addJoint(parent, pinocchio::JointModelRX(), at, name)
        : e[1] == 1           ? model.addJoint(parent, pinocchio::JointModelRY(), at, name)
        : e[2] == 1           ? model.addJoint(parent, pinocchio::JointModelRZ(), at, name)
        : model.addJoint(parent, pinocchio::JointModelRevoluteUnaligned(e), at, name);
    model.inertias[id] = pinocchio::Inertia::FromDynamicParameters(
        Eigen::Map<const Eigen::Matrix<double, 10, 1>>(body));
}

/* Without gravity, v' is f while the origin rests. */
extern "C" void end(const int *places)
{
    model.gravity.setZero();
    delete data;
    data = new Data(model);
    place.assign(places, places + model.nv - 6);
    q_ = Vector::Zero(model.nq);
    q_[6] = 1;
    v_ = a_ = Vector::Zero(model.nv);
}

static void state(const double *q, const double *qd, const double *third)
{
    const int n = model.nv - 6;
    for (int j = 0; j < n; ++j) {
        q_[place[j] + 1] = q[j];
        v_[place[j]] = qd[j];
        a_[place[j]] = third[j];
    }
    v_.segment<3>(3) = Eigen::Map<const Eigen::Vector3d>(qd + n);
    a_.head<6>() = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(third + n);
}

static void store(const Vector &found, double *base, double *joints)
{
    Eigen::Map<Vector>(base, 6) = found.head<6>();
    for (int j = 0; j < model.nv - 6; ++j)
        joints[j] = found[place[j]];
}

#define LOOP(name, count, ...)                                                                     \
    extern "C" void name(std::size_t N, const double *q, const double *qd, const double *third,    \
        double *out)                                                                               \
    {                                                                                              \
        const std::size_t m = model.nv;                                                            \
        for (std::size_t k = 0; k < N; ++k) {                                                      \
            state(q + k * m, qd + k * m, third + k * m);                                           \
            double *to = out + k * count;                                                          \
            __VA_ARGS__                                                                            \
        }                                                                                          \
    }
LOOP(inverse_dynamics, m, { store(pinocchio::rnea(model, *data, q_, v_, a_), to, to + 6); })
LOOP(mass_matrix, m *m, { Eigen::Map<Rows>(to, m, m) = pinocchio::crba(model, *data, q_); })
LOOP(forward_dynamics, m, { store(pinocchio::aba(model, *data, q_, v_, a_), to + m - 6, to); })
