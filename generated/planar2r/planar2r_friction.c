/* planar2r: torque of the friction that joints and couplings declare; effects are not in it
 * 0 operations for one sample, as written here.
 */
#include "planar2r.h"

planar2r_IN_SECTION void planar2r_friction(const double qd[2], const double X[4], double tau[2])
{
    (void)qd;
    (void)X;
    tau[0] = 0.0;
    tau[1] = 0.0;
}
