/* planar2r: torque of the friction that joints and couplings declare; effects are not in it
 * 0 operations for one sample, as written here.
 */
#include "planar2r.h"

void planar2r_friction(const double qd[2], const double X[4], double tau[2])
{
    (void)qd;
    (void)X;
    tau[0] = 0.0;
    tau[1] = 0.0;
}

void planar2r_friction_batch(size_t N, const double *qd, const double *X, double *tau)
{
    for (size_t k = 0; k < N; ++k) {
        planar2r_friction(&qd[k * 2u], X, &tau[k * 2u]);
    }
}
