/* planar2r: homogeneous transforms 0T_j of all links, fixed ones included
 * 6 mul, 2 add, 2 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

planar2r_IN_SECTION void planar2r_frames(const double q[2], double T_out[32])
{
    T_out[2] = 0.0;
    T_out[3] = 0.0;
    T_out[6] = 0.0;
    T_out[7] = 0.0;
    T_out[8] = 0.0;
    T_out[9] = 0.0;
    T_out[11] = 0.0;
    T_out[12] = 0.0;
    T_out[13] = 0.0;
    T_out[14] = 0.0;
    T_out[18] = 0.0;
    T_out[22] = 0.0;
    T_out[24] = 0.0;
    T_out[25] = 0.0;
    T_out[27] = 0.0;
    T_out[28] = 0.0;
    T_out[29] = 0.0;
    T_out[30] = 0.0;
    T_out[10] = 1.0;
    T_out[15] = 1.0;
    T_out[26] = 1.0;
    T_out[31] = 1.0;
    const planar2r_angles2 q_0 = planar2r_sincos2(q);
    const double C1 = q_0.c[0];
    T_out[0] = C1;
    T_out[5] = C1;
    const double S1 = q_0.s[0];
    T_out[1] = -S1;
    T_out[4] = S1;
    const double C2 = q_0.c[1];
    const double S2 = q_0.s[1];
    const double pd2_1 = planar2r_geometry_L1 * C1;
    T_out[19] = pd2_1;
    const double pd2_2 = planar2r_geometry_L1 * S1;
    T_out[23] = pd2_2;
    const double R1e2_1 = C1 * C2 - S1 * S2;
    T_out[16] = R1e2_1;
    T_out[21] = R1e2_1;
    const double R1e2_2 = C1 * S2 + S1 * C2;
    T_out[17] = -R1e2_2;
    T_out[20] = R1e2_2;
}
