/* planar2r: torque of gravity on the links, without springs and friction
 * 0 operations for one sample, as written here.
 */
#include "planar2r.h"

planar2r_IN_SECTION void planar2r_gravity_torque(const double q[2], const double X[4], double tau[2])
{
    (void)q;
    (void)X;
    tau[0] = 0.0;
    tau[1] = 0.0;
}
