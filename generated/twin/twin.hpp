/* twin: the model as a struct in C++17, for programs that are templates over robots.
 *
 *     template <class Robot>
 *     auto torque(const std::array<typename Robot::real, Robot::joints> &q, ...)
 *     { return Robot::inverse_dynamics(q, qd, qdd, X); }          // torque<twin_robot>(...)
 *
 * Every kernel of twin.h has two forms: one writes into the caller's memory, the other returns
 * std::array (a tuple of them where there are several, an empty optional where C returns nonzero).
 * Arrays are C arrays, std::array, std::vector, std::span, Eigen's vectors and Maps: whatever has data()
 * and size(). Matrices are row-major: Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>>(J.data()).
 * A number of entries that the compiler knows is checked by it, any other by assert; Eigen's
 * matrices in another order, or with gaps, do not compile.
 */
#ifndef twin_MODEL_HPP
#define twin_MODEL_HPP

#include <array>
#include <cassert>
#include <cstddef>
#include <optional>
#include <tuple>
#include <type_traits>

#include "twin.h"

struct twin_robot {
    using real = twin_real;
    static constexpr const char *name = "twin";
    static constexpr std::size_t joints = twin_JOINTS;
    static constexpr std::size_t parameters = twin_PARAMETERS;
    static constexpr std::size_t inertial = twin_INERTIAL;
    static constexpr std::array<const char *, parameters> parameter_names{ {
        "ZZ1R",
        "XX2R",
        "XY2",
        "XZ2R",
        "YZ2",
        "ZZ2R",
        "MX2R",
        "MY2",
        "XX3R",
        "XY3",
        "XZ3",
        "YZ3",
        "ZZ3R",
        "MX3",
        "MY3R",
        "IA3",
        "XX4R",
        "XY4",
        "XZ4",
        "YZ4",
        "ZZ4",
        "MX4",
        "MY4",
        "IA4",
        "XX5R",
        "XY5R",
        "XZ5R",
        "YZ5R",
        "ZZ5R",
        "MX5",
        "MY5",
        "MX6",
        "MY6R",
        "MZ6",
        "M6R",
        "IA6",
        "XX7R",
        "XY7",
        "XZ7",
        "YZ7",
        "ZZ7",
        "MX7",
        "MY7",
        "IA7",
        "FS1",
        "FV1",
        "FS2",
        "FV2",
        "FS3",
        "FV3",
        "FS4",
        "FV4",
        "FS5",
        "FV5",
        "FS6",
        "FV6",
        "FS7",
        "FV7",
    } };

private:
    /* How many numbers a container holds, where its type tells: 0 where it does not. */
    template <class C, class = void> struct held {
        static constexpr std::size_t size = 0;
        static constexpr bool plain = true; /* one after the other, matrices row by row */
    };
    template <class C> struct held<C, decltype(static_cast<void>(std::tuple_size<C>::value))> {
        static constexpr std::size_t size = std::tuple_size<C>::value;
        static constexpr bool plain = true;
    };
    template <class C> struct held<C, decltype(static_cast<void>(C::extent))> {
        static constexpr bool dynamic = C::extent == static_cast<std::size_t>(-1);
        static constexpr std::size_t size = dynamic ? 0 : C::extent;
        static constexpr bool plain = true;
    };
    template <class C> struct held<C, decltype(static_cast<void>(C::SizeAtCompileTime))> { /* Eigen */
        static constexpr int fixed = static_cast<int>(C::SizeAtCompileTime);
        static constexpr int columns = static_cast<int>(C::ColsAtCompileTime);
        static constexpr int outer = static_cast<int>(C::OuterStrideAtCompileTime);
        static constexpr bool rows = static_cast<bool>(C::IsRowMajor) && outer == columns;
        static constexpr std::size_t size = fixed < 0 ? 0 : static_cast<std::size_t>(fixed);
        static constexpr bool plain = static_cast<int>(C::InnerStrideAtCompileTime) == 1
            && (static_cast<bool>(C::IsVectorAtCompileTime) || rows);
    };

public:
    /* N numbers that somebody else holds. */
    template <class T, std::size_t N> class view {
    public:
        static constexpr std::size_t extent = N;
        constexpr view(T (&numbers)[N]) noexcept : first_(numbers) {}
        /* For N numbers from here on, unchecked. */
        constexpr explicit view(T *first) noexcept : first_(first) {}
        template <class C,
            class = std::enable_if_t<std::is_convertible_v<decltype(std::declval<C &>().data()), T *>>>
        constexpr view(C &&numbers) noexcept : first_(numbers.data())
        {
            using of = held<std::remove_cv_t<std::remove_reference_t<C>>>;
            static_assert(of::size == 0 || of::size == N, "another number of entries is needed");
            static_assert(of::plain, "a row-major matrix without gaps is needed");
            assert(static_cast<std::size_t>(numbers.size()) == N);
        }
        constexpr T *data() const noexcept { return first_; }
        constexpr std::size_t size() const noexcept { return N; }
        constexpr T &operator[](std::size_t i) const noexcept { return first_[i]; }
        constexpr T *begin() const noexcept { return first_; }
        constexpr T *end() const noexcept { return first_ + N; }

    private:
        T *first_;
    };
    template <std::size_t N> using input = view<const real, N>;
    template <std::size_t N> using output = view<real, N>;

    /* columns DE + DU of kinetic plus potential energy: E + U = out . X
     * out: 44
     */
    static void energy_regressor(input<7> q, input<7> qd, output<44> out) noexcept
    {
        twin_energy_regressor(q.data(), qd.data(), out.data());
    }
    [[nodiscard]] static std::array<real, 44> energy_regressor(input<7> q, input<7> qd) noexcept
    {
        std::array<real, 44> out;
        energy_regressor(q, qd, out);
        return out;
    }

    /* columns of the power that friction takes: P = out . X[p_inertial..p)
     * out: 14
     */
    static void friction_power(input<7> q, input<7> qd, output<14> out) noexcept
    {
        twin_friction_power(q.data(), qd.data(), out.data());
    }
    [[nodiscard]] static std::array<real, 14> friction_power(input<7> q, input<7> qd) noexcept
    {
        std::array<real, 14> out;
        friction_power(q, qd, out);
        return out;
    }

    /* columns of friction torque: out X[p_inertial..p)
     * out: 7, 14
     */
    static void friction_torque(input<7> q, input<7> qd, output<98> out) noexcept
    {
        twin_friction_torque(q.data(), qd.data(), out.data());
    }
    [[nodiscard]] static std::array<real, 98> friction_torque(input<7> q, input<7> qd) noexcept
    {
        std::array<real, 98> out;
        friction_torque(q, qd, out);
        return out;
    }

    /* columns of power: qd' tau = out . X, the rate of energy plus friction
     * out: 58
     */
    static void power_regressor(input<7> q, input<7> qd, input<7> qdd, output<58> out) noexcept
    {
        twin_power_regressor(q.data(), qd.data(), qdd.data(), out.data());
    }
    [[nodiscard]] static std::array<real, 58> power_regressor(input<7> q, input<7> qd, input<7> qdd) noexcept
    {
        std::array<real, 58> out;
        power_regressor(q, qd, qdd, out);
        return out;
    }

    /* columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq
     * p_out: 7, 44
     * dl_out: 7, 44
     */
    static void momentum_regressor(input<7> q, input<7> qd, output<308> p_out, output<308> dl_out) noexcept
    {
        twin_momentum_regressor(q.data(), qd.data(), p_out.data(), dl_out.data());
    }
    [[nodiscard]] static std::tuple<std::array<real, 308>, std::array<real, 308>> momentum_regressor(input<7> q, input<7> qd) noexcept
    {
        std::array<real, 308> p_out;
        std::array<real, 308> dl_out;
        momentum_regressor(q, qd, p_out, dl_out);
        return { p_out, dl_out };
    }

    /* columns of torque: tau = out X, friction included
     * out: 7, 58
     */
    static void torque_regressor(input<7> q, input<7> qd, input<7> qdd, output<406> out) noexcept
    {
        twin_torque_regressor(q.data(), qd.data(), qdd.data(), out.data());
    }
    [[nodiscard]] static std::array<real, 406> torque_regressor(input<7> q, input<7> qd, input<7> qdd) noexcept
    {
        std::array<real, 406> out;
        torque_regressor(q, qd, qdd, out);
        return out;
    }

    /* torque of a motion: tau = M qdd + C qd + g + friction
     * tau: 7
     */
    static void inverse_dynamics(input<7> q, input<7> qd, input<7> qdd, input<parameters> X, output<7> tau) noexcept
    {
        twin_inverse_dynamics(q.data(), qd.data(), qdd.data(), X.data(), tau.data());
    }
    [[nodiscard]] static std::array<real, 7> inverse_dynamics(input<7> q, input<7> qd, input<7> qdd, input<parameters> X) noexcept
    {
        std::array<real, 7> tau;
        inverse_dynamics(q, qd, qdd, X, tau);
        return tau;
    }

    /* mass matrix M(q)
     * M: 7, 7
     */
    static void mass_matrix(input<7> q, input<parameters> X, output<49> M) noexcept
    {
        twin_mass_matrix(q.data(), X.data(), M.data());
    }
    [[nodiscard]] static std::array<real, 49> mass_matrix(input<7> q, input<parameters> X) noexcept
    {
        std::array<real, 49> M;
        mass_matrix(q, X, M);
        return M;
    }

    /* torque that holds the arm at rest, without friction
     * tau: 7
     */
    static void gravity_torque(input<7> q, input<parameters> X, output<7> tau) noexcept
    {
        twin_gravity_torque(q.data(), X.data(), tau.data());
    }
    [[nodiscard]] static std::array<real, 7> gravity_torque(input<7> q, input<parameters> X) noexcept
    {
        std::array<real, 7> tau;
        gravity_torque(q, X, tau);
        return tau;
    }

    /* C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric
     * C: 7, 7
     */
    static void coriolis(input<7> q, input<7> qd, input<parameters> X, output<49> C) noexcept
    {
        twin_coriolis(q.data(), qd.data(), X.data(), C.data());
    }
    [[nodiscard]] static std::array<real, 49> coriolis(input<7> q, input<7> qd, input<parameters> X) noexcept
    {
        std::array<real, 49> C;
        coriolis(q, qd, X, C);
        return C;
    }

    /* h = C qd + g + friction
     * h: 7
     */
    static void bias_torque(input<7> q, input<7> qd, input<parameters> X, output<7> h) noexcept
    {
        twin_bias_torque(q.data(), qd.data(), X.data(), h.data());
    }
    [[nodiscard]] static std::array<real, 7> bias_torque(input<7> q, input<7> qd, input<parameters> X) noexcept
    {
        std::array<real, 7> h;
        bias_torque(q, qd, X, h);
        return h;
    }

    /* accelerations under torques tau; not 0 where M is not positive definite; nonzero, or empty: it has none
     * qdd: 7
     */
    static int forward_dynamics(input<7> q, input<7> qd, input<7> tau, input<parameters> X, output<7> qdd) noexcept
    {
        return twin_forward_dynamics(q.data(), qd.data(), tau.data(), X.data(), qdd.data());
    }
    [[nodiscard]] static std::optional<std::array<real, 7>> forward_dynamics(input<7> q, input<7> qd, input<7> tau, input<parameters> X) noexcept
    {
        std::array<real, 7> qdd;
        if (forward_dynamics(q, qd, tau, X, qdd) != 0) {
            return std::nullopt;
        }
        return qdd;
    }

    /* kinetic energy T and potential energy U, U up to a constant
     * T_out: 1
     * U_out: 1
     */
    static void energy(input<7> q, input<7> qd, input<parameters> X, output<1> T_out, output<1> U_out) noexcept
    {
        twin_energy(q.data(), qd.data(), X.data(), T_out.data(), U_out.data());
    }
    [[nodiscard]] static std::tuple<std::array<real, 1>, std::array<real, 1>> energy(input<7> q, input<7> qd, input<parameters> X) noexcept
    {
        std::array<real, 1> T_out;
        std::array<real, 1> U_out;
        energy(q, qd, X, T_out, U_out);
        return { T_out, U_out };
    }

    /* homogeneous transforms 0T_j of all links, fixed ones included
     * T_out: 7, 4, 4
     */
    static void frames(input<7> q, output<112> T_out) noexcept
    {
        twin_frames(q.data(), T_out.data());
    }
    [[nodiscard]] static std::array<real, 112> frames(input<7> q) noexcept
    {
        std::array<real, 112> T_out;
        frames(q, T_out);
        return T_out;
    }

    /* Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning
     * J_out: 6, 7
     */
    static void jacobian(input<7> q, output<42> J_out) noexcept
    {
        twin_jacobian(q.data(), J_out.data());
    }
    [[nodiscard]] static std::array<real, 42> jacobian(input<7> q) noexcept
    {
        std::array<real, 42> J_out;
        jacobian(q, J_out);
        return J_out;
    }

    /* mass_matrix, bias_torque, gravity_torque, jacobian and frames in one call, which turns each angle once
     * M: 7, 7
     * h: 7
     * tau: 7
     * J_out: 6, 7
     * T_out: 7, 4, 4
     */
    static void all_terms(input<7> q, input<7> qd, input<parameters> X, output<49> M, output<7> h, output<7> tau, output<42> J_out, output<112> T_out) noexcept
    {
        twin_all_terms(q.data(), qd.data(), X.data(), M.data(), h.data(), tau.data(), J_out.data(), T_out.data());
    }
    [[nodiscard]] static std::tuple<std::array<real, 49>, std::array<real, 7>, std::array<real, 7>, std::array<real, 42>, std::array<real, 112>> all_terms(input<7> q, input<7> qd, input<parameters> X) noexcept
    {
        std::array<real, 49> M;
        std::array<real, 7> h;
        std::array<real, 7> tau;
        std::array<real, 42> J_out;
        std::array<real, 112> T_out;
        all_terms(q, qd, X, M, h, tau, J_out, T_out);
        return { M, h, tau, J_out, T_out };
    }

    /* columns of M qddr + C(q, qd) qdr + g + friction(qd) = out X, C of Christoffel's symbols
     * out: 7, 58
     */
    static void slotine_li_regressor(input<7> q, input<7> qd, input<7> qdr, input<7> qddr, output<406> out) noexcept
    {
        twin_slotine_li_regressor(q.data(), qd.data(), qdr.data(), qddr.data(), out.data());
    }
    [[nodiscard]] static std::array<real, 406> slotine_li_regressor(input<7> q, input<7> qd, input<7> qdr, input<7> qddr) noexcept
    {
        std::array<real, 406> out;
        slotine_li_regressor(q, qd, qdr, qddr, out);
        return out;
    }

    /* M qddr + C(q, qd) qdr + g + friction(qd), C of Christoffel's symbols
     * tau: 7
     */
    static void slotine_li_torque(input<7> q, input<7> qd, input<7> qdr, input<7> qddr, input<parameters> X, output<7> tau) noexcept
    {
        twin_slotine_li_torque(q.data(), qd.data(), qdr.data(), qddr.data(), X.data(), tau.data());
    }
    [[nodiscard]] static std::array<real, 7> slotine_li_torque(input<7> q, input<7> qd, input<7> qdr, input<7> qddr, input<parameters> X) noexcept
    {
        std::array<real, 7> tau;
        slotine_li_torque(q, qd, qdr, qddr, X, tau);
        return tau;
    }

    /* p = M qd and rate = C' qd - g: dp/dt = tau - friction + rate
     * p_out: 7
     * rate_out: 7
     */
    static void generalized_momentum(input<7> q, input<7> qd, input<parameters> X, output<7> p_out, output<7> rate_out) noexcept
    {
        twin_generalized_momentum(q.data(), qd.data(), X.data(), p_out.data(), rate_out.data());
    }
    [[nodiscard]] static std::tuple<std::array<real, 7>, std::array<real, 7>> generalized_momentum(input<7> q, input<7> qd, input<parameters> X) noexcept
    {
        std::array<real, 7> p_out;
        std::array<real, 7> rate_out;
        generalized_momentum(q, qd, X, p_out, rate_out);
        return { p_out, rate_out };
    }

    /* torque of the friction that joints and couplings declare; effects are not in it
     * tau: 7
     */
    static void friction(input<7> qd, input<parameters> X, output<7> tau) noexcept
    {
        twin_friction(qd.data(), X.data(), tau.data());
    }
    [[nodiscard]] static std::array<real, 7> friction(input<7> qd, input<parameters> X) noexcept
    {
        std::array<real, 7> tau;
        friction(qd, X, tau);
        return tau;
    }

    /* dtau/dq and dtau/dqd; dtau/dqdd is mass_matrix; the derivative of sign(qd) is 0
     * dq_out: 7, 7
     * dqd_out: 7, 7
     */
    static void inverse_dynamics_derivatives(input<7> q, input<7> qd, input<7> qdd, input<parameters> X, output<49> dq_out, output<49> dqd_out) noexcept
    {
        twin_inverse_dynamics_derivatives(q.data(), qd.data(), qdd.data(), X.data(), dq_out.data(), dqd_out.data());
    }
    [[nodiscard]] static std::tuple<std::array<real, 49>, std::array<real, 49>> inverse_dynamics_derivatives(input<7> q, input<7> qd, input<7> qdd, input<parameters> X) noexcept
    {
        std::array<real, 49> dq_out;
        std::array<real, 49> dqd_out;
        inverse_dynamics_derivatives(q, qd, qdd, X, dq_out, dqd_out);
        return { dq_out, dqd_out };
    }

    /* dqdd/dq, dqdd/dqd and dqdd/dtau; the derivative of sign(qd) is 0; nonzero, or empty: it has none
     * dq_out: 7, 7
     * dqd_out: 7, 7
     * dtau_out: 7, 7
     */
    static int forward_dynamics_derivatives(input<7> q, input<7> qd, input<7> tau, input<parameters> X, output<49> dq_out, output<49> dqd_out, output<49> dtau_out) noexcept
    {
        return twin_forward_dynamics_derivatives(q.data(), qd.data(), tau.data(), X.data(), dq_out.data(), dqd_out.data(), dtau_out.data());
    }
    [[nodiscard]] static std::optional<std::tuple<std::array<real, 49>, std::array<real, 49>, std::array<real, 49>>> forward_dynamics_derivatives(input<7> q, input<7> qd, input<7> tau, input<parameters> X) noexcept
    {
        std::array<real, 49> dq_out;
        std::array<real, 49> dqd_out;
        std::array<real, 49> dtau_out;
        if (forward_dynamics_derivatives(q, qd, tau, X, dq_out, dqd_out, dtau_out) != 0) {
            return std::nullopt;
        }
        return std::make_tuple(dq_out, dqd_out, dtau_out);
    }

    /* x of M(q) x = b; nonzero, or empty: it has none
     * x: 7
     */
    static int solve_mass_matrix(input<7> q, input<7> b, input<parameters> X, output<7> x) noexcept
    {
        return twin_solve_mass_matrix(q.data(), b.data(), X.data(), x.data());
    }
    [[nodiscard]] static std::optional<std::array<real, 7>> solve_mass_matrix(input<7> q, input<7> b, input<parameters> X) noexcept
    {
        std::array<real, 7> x;
        if (solve_mass_matrix(q, b, X, x) != 0) {
            return std::nullopt;
        }
        return x;
    }

    /* M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with L from its last row; nonzero, or empty: it has none
     * L_out: 7, 7
     * D_out: 7
     */
    static int mass_matrix_factor(input<7> q, input<parameters> X, output<49> L_out, output<7> D_out) noexcept
    {
        return twin_mass_matrix_factor(q.data(), X.data(), L_out.data(), D_out.data());
    }
    [[nodiscard]] static std::optional<std::tuple<std::array<real, 49>, std::array<real, 7>>> mass_matrix_factor(input<7> q, input<parameters> X) noexcept
    {
        std::array<real, 49> L_out;
        std::array<real, 7> D_out;
        if (mass_matrix_factor(q, X, L_out, D_out) != 0) {
            return std::nullopt;
        }
        return std::make_tuple(L_out, D_out);
    }

    /* Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning; nonzero, or empty: there is no such link
     * J: 6, 7
     */
    static int link_jacobian(input<7> q, std::size_t link, input<3> point, output<42> J) noexcept
    {
        return twin_link_jacobian(q.data(), link, point.data(), J.data());
    }
    [[nodiscard]] static std::optional<std::array<real, 42>> link_jacobian(input<7> q, std::size_t link, input<3> point) noexcept
    {
        std::array<real, 42> J;
        if (link_jacobian(q, link, point, J) != 0) {
            return std::nullopt;
        }
        return J;
    }

    /* dJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0; nonzero, or empty: there is no such link
     * a: 6
     */
    static int link_drift(input<7> q, input<7> qd, std::size_t link, input<3> point, output<6> a) noexcept
    {
        return twin_link_drift(q.data(), qd.data(), link, point.data(), a.data());
    }
    [[nodiscard]] static std::optional<std::array<real, 6>> link_drift(input<7> q, input<7> qd, std::size_t link, input<3> point) noexcept
    {
        std::array<real, 6> a;
        if (link_drift(q, qd, link, point, a) != 0) {
            return std::nullopt;
        }
        return a;
    }

    /* operational space of a point in the frame of a link, in frame 0: Lambda = (J M^-1 J')^-1 of the rows of link_jacobian with select 1 (the others 0), J# = M^-1 J' Lambda, and the part (I - J' J#') tau of a torque that does not accelerate these rows; not 0 where these rows depend on each other, or M is not positive definite; nonzero, or empty: there is no such link or it has none
     * Lambda_out: 6, 6
     * inverse_out: 7, 6
     * null_out: 7
     */
    static int operational_space(input<7> q, std::size_t link, input<3> point, input<6> select, input<7> tau, input<parameters> X, output<36> Lambda_out, output<42> inverse_out, output<7> null_out) noexcept
    {
        return twin_operational_space(q.data(), link, point.data(), select.data(), tau.data(), X.data(), Lambda_out.data(), inverse_out.data(), null_out.data());
    }
    [[nodiscard]] static std::optional<std::tuple<std::array<real, 36>, std::array<real, 42>, std::array<real, 7>>> operational_space(input<7> q, std::size_t link, input<3> point, input<6> select, input<7> tau, input<parameters> X) noexcept
    {
        std::array<real, 36> Lambda_out;
        std::array<real, 42> inverse_out;
        std::array<real, 7> null_out;
        if (operational_space(q, link, point, select, tau, X, Lambda_out, inverse_out, null_out) != 0) {
            return std::nullopt;
        }
        return std::make_tuple(Lambda_out, inverse_out, null_out);
    }

    /* X from the standard parameters, in this order: XX1, XY1, XZ1, YY1, YZ1, ZZ1, MX1, MY1, MZ1, M1, IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, M2, IA2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3, MY3, MZ3, M3, IA3, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, IA4, XX5, XY5, XZ5, YY5, YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6, XZ6, YY6, YZ6, ZZ6, MX6, MY6, MZ6, M6, IA6, XX7, XY7, XZ7, YY7, YZ7, ZZ7, MX7, MY7, MZ7, M7, IA7, FS1, FV1, FS2, FV2, FS3, FV3, FS4, FV4, FS5, FV5, FS6, FV6, FS7, FV7
     * X: 58
     */
    static void base_parameters(input<91> standard, output<58> X) noexcept
    {
        twin_base_parameters(standard.data(), X.data());
    }
    [[nodiscard]] static std::array<real, 58> base_parameters(input<91> standard) noexcept
    {
        std::array<real, 58> X;
        base_parameters(standard, X);
        return X;
    }

    /* fix a body on a link, in X: its mass, the centre of mass in the frame of the link, and inertia XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it off; nonzero, or empty: there is no such link
     */
    static int add_body(output<parameters> X, std::size_t link, real mass, input<3> com, input<6> inertia) noexcept
    {
        return twin_add_body(X.data(), link, mass, com.data(), inertia.data());
    }
};

#endif
