/* planar2r: Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning
 * 2 mul, 1 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_jacobian(const double q[2], double J_out[12])
{
    J_out[1] = 0.0;
    J_out[3] = 0.0;
    J_out[4] = 0.0;
    J_out[5] = 0.0;
    J_out[6] = 0.0;
    J_out[7] = 0.0;
    J_out[8] = 0.0;
    J_out[9] = 0.0;
    J_out[10] = 1.0;
    J_out[11] = 1.0;
    const planar2r_angles1 q_0 = planar2r_sincos1(q);
    const double C1 = q_0.c[0];
    const double S1 = q_0.s[0];
    const double pd2_1 = planar2r_geometry_L1 * C1;
    J_out[2] = pd2_1;
    const double pd2_2 = planar2r_geometry_L1 * S1;
    J_out[0] = -pd2_2;
}
