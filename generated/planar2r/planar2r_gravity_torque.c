/* planar2r: torque that holds the arm at rest, without friction
 * 0 operations for one sample, as written here.
 */
#include "planar2r.h"

void planar2r_gravity_torque(const double q[2], const double X[4], double tau[2])
{
    (void)q;
    (void)X;
    tau[0] = 0.0;
    tau[1] = 0.0;
}

void planar2r_gravity_torque_batch(size_t N, const double *q, const double *X, double *tau)
{
    for (size_t k = 0; k < N; ++k) {
        planar2r_gravity_torque(&q[k * 2u], X, &tau[k * 2u]);
    }
}
