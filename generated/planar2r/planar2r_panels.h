/* planar2r: kernels on panels: as many samples at once as a vector register holds.
 *
 * The compiler's flags choose the width: 8 doubles or 16 floats with AVX-512, half with AVX and
 * AVX2, a quarter with SSE2 and NEON; 1 in C++, with another compiler than gcc and clang, and on
 * other processors. planar2r_KERNEL_width() tells the width that a kernel was compiled with.
 *
 * Inputs are rows of samples. strides[i] is the distance of two rows of input i, in numbers, in the
 * order of the arguments; 0: all samples share it. NULL: rows without gaps, X shared.
 * Outputs of _rows are rows without gaps. Those of _panels are (ceil(N / width), size, width): entry
 * [k, i, l] is output i of sample k width + l. What stands behind the last sample repeats it, and
 * entries that are zero for every sample may be left as they were: put zeros there once.
 * stream: not 0 writes outputs past the cache, where they begin at a multiple of 64 bytes.
 * Returns the status of the _batch form; 0 where a kernel cannot fail.
 */
#ifndef planar2r_PANELS_H
#define planar2r_PANELS_H

#include "planar2r.h"

#ifdef __cplusplus
extern "C" {
#endif

size_t planar2r_energy_regressor_width(void);
int planar2r_energy_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out);
int planar2r_energy_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *out);

size_t planar2r_power_regressor_width(void);
int planar2r_power_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out);
int planar2r_power_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out);

size_t planar2r_momentum_regressor_width(void);
int planar2r_momentum_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out);
int planar2r_momentum_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, double *p_out, double *dl_out);

size_t planar2r_torque_regressor_width(void);
int planar2r_torque_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out);
int planar2r_torque_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, double *out);

size_t planar2r_inverse_dynamics_width(void);
int planar2r_inverse_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau);
int planar2r_inverse_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *tau);

size_t planar2r_mass_matrix_width(void);
int planar2r_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M);
int planar2r_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *M);

size_t planar2r_gravity_torque_width(void);
int planar2r_gravity_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *tau);
int planar2r_gravity_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *tau);

size_t planar2r_coriolis_width(void);
int planar2r_coriolis_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C);
int planar2r_coriolis_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *C);

size_t planar2r_bias_torque_width(void);
int planar2r_bias_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h);
int planar2r_bias_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *h);

size_t planar2r_forward_dynamics_width(void);
int planar2r_forward_dynamics_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd);
int planar2r_forward_dynamics_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *qdd);

size_t planar2r_energy_width(void);
int planar2r_energy_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *T_out, double *U_out);
int planar2r_energy_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *T_out, double *U_out);

size_t planar2r_frames_width(void);
int planar2r_frames_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out);
int planar2r_frames_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *T_out);

size_t planar2r_jacobian_width(void);
int planar2r_jacobian_rows(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out);
int planar2r_jacobian_panels(int stream, size_t N, const size_t *strides,
    const double *q, double *J_out);

size_t planar2r_slotine_li_regressor_width(void);
int planar2r_slotine_li_regressor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out);
int planar2r_slotine_li_regressor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, double *out);

size_t planar2r_slotine_li_torque_width(void);
int planar2r_slotine_li_torque_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X,
    double *tau);
int planar2r_slotine_li_torque_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdr, const double *qddr, const double *X,
    double *tau);

size_t planar2r_generalized_momentum_width(void);
int planar2r_generalized_momentum_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out);
int planar2r_generalized_momentum_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *X, double *p_out, double *rate_out);

size_t planar2r_friction_width(void);
int planar2r_friction_rows(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau);
int planar2r_friction_panels(int stream, size_t N, const size_t *strides,
    const double *qd, const double *X, double *tau);

size_t planar2r_inverse_dynamics_derivatives_width(void);
int planar2r_inverse_dynamics_derivatives_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double
    *dqd_out);
int planar2r_inverse_dynamics_derivatives_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *qdd, const double *X, double *dq_out, double
    *dqd_out);

size_t planar2r_forward_dynamics_derivatives_width(void);
int planar2r_forward_dynamics_derivatives_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *dq_out, double
    *dqd_out, double *dtau_out);
int planar2r_forward_dynamics_derivatives_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *qd, const double *tau, const double *X, double *dq_out, double
    *dqd_out, double *dtau_out);

size_t planar2r_solve_mass_matrix_width(void);
int planar2r_solve_mass_matrix_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x);
int planar2r_solve_mass_matrix_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *b, const double *X, double *x);

size_t planar2r_mass_matrix_factor_width(void);
int planar2r_mass_matrix_factor_rows(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out);
int planar2r_mass_matrix_factor_panels(int stream, size_t N, const size_t *strides,
    const double *q, const double *X, double *L_out, double *D_out);

#ifdef __cplusplus
}
#endif

#endif
