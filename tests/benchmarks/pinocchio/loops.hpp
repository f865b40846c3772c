// A C++ loop over samples, outputs stored, for each of Pinocchio's algorithms; begun by model.cpp.
#define BOOST_VARIANT_USE_RELAXED_GET_BY_DEFAULT // there is no mimic joint to get
#include <cstddef>
#include <pinocchio/multibody.hpp>

// The joints that arms have: each algorithm is compiled for every joint of a collection, and
// Pinocchio's own has 25. Choosing among fewer at run time can only be faster.
template<typename S, int O>
struct ArmJoints {
    using Scalar = S;
    static constexpr int Options = O;
    using JointModelRX = pinocchio::JointModelRevoluteTpl<S, O, 0>;
    using JointModelRY = pinocchio::JointModelRevoluteTpl<S, O, 1>;
    using JointModelRZ = pinocchio::JointModelRevoluteTpl<S, O, 2>;
    using JointModelPZ = pinocchio::JointModelPrismaticTpl<S, O, 2>;
    using JointModelVariant = boost::variant<JointModelRX, JointModelRY, JointModelRZ, JointModelPZ>;
    using JointDataRX = pinocchio::JointDataRevoluteTpl<S, O, 0>;
    using JointDataRY = pinocchio::JointDataRevoluteTpl<S, O, 1>;
    using JointDataRZ = pinocchio::JointDataRevoluteTpl<S, O, 2>;
    using JointDataPZ = pinocchio::JointDataPrismaticTpl<S, O, 2>;
    using JointDataVariant = boost::variant<JointDataRX, JointDataRY, JointDataRZ, JointDataPZ>;
};
using Model = pinocchio::ModelTpl<double, 0, ArmJoints>;
using Data = pinocchio::DataTpl<double, 0, ArmJoints>;
using Vector = Eigen::VectorXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
extern Model model;
extern Data *data;

#define LOOP(name, third, size, ...)                                                               \
    extern "C" void name(std::size_t N, const double *q, const double *qd, const double *third,    \
        double *out)                                                                               \
    {                                                                                              \
        const auto n = model.nv;                                                                   \
        const std::size_t count = size;                                                            \
        static Vector a, b, c; /* allocated once */                                                \
        for (Vector *x : { &a, &b, &c })                                                           \
            x->resize(n);                                                                          \
        for (std::size_t k = 0; k < N; ++k) {                                                      \
            a = Eigen::Map<const Vector>(q + k * n, n);                                            \
            b = Eigen::Map<const Vector>(qd + k * n, n);                                           \
            c = Eigen::Map<const Vector>(third + k * n, n);                                        \
            double *to = out + k * count;                                                          \
            __VA_ARGS__                                                                            \
        }                                                                                          \
    }
