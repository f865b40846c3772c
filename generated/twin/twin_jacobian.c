/* twin: Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning
 * 11 mul, 8 add, 2 sincos for one sample, as written here.
 */
#include "twin.h"
#include "twin_math.h"

void twin_jacobian(const double q[7], double J_out[42])
{
    const double b2 = 0.6;
    const double d2 = 0.2;
    const double d3 = 0.3;
    J_out[1] = 0.0;
    J_out[2] = 0.0;
    J_out[3] = 0.0;
    J_out[6] = 0.0;
    J_out[8] = 0.0;
    J_out[9] = 0.0;
    J_out[10] = 0.0;
    J_out[13] = 0.0;
    J_out[14] = 0.0;
    J_out[15] = 0.0;
    J_out[16] = 0.0;
    J_out[17] = 0.0;
    J_out[20] = 0.0;
    J_out[21] = 0.0;
    J_out[22] = 0.0;
    J_out[23] = 0.0;
    J_out[24] = 0.0;
    J_out[26] = 0.0;
    J_out[28] = 0.0;
    J_out[29] = 0.0;
    J_out[30] = 0.0;
    J_out[31] = 0.0;
    J_out[33] = 0.0;
    J_out[36] = 0.0;
    J_out[37] = 0.0;
    J_out[38] = 0.0;
    J_out[39] = 0.0;
    J_out[40] = 0.0;
    J_out[41] = 0.0;
    J_out[35] = 1.0;
    const twin_angles1 q_0 = twin_sincos1(q);
    const twin_angles1 q_4 = twin_sincos1(&q[4]);
    const double C1 = q_0.c[0];
    J_out[25] = -C1;
    J_out[27] = -C1;
    const double S1 = q_0.s[0];
    J_out[32] = -S1;
    J_out[34] = -S1;
    const double C5 = q_4.c[0];
    J_out[19] = -C5;
    const double S5 = q_4.s[0];
    const double R6 = q[5] + d3;
    const double pr6_3 = b2 - C5 * R6;
    const double a5_3 = pr6_3 - b2;
    const double v5_1 = -S1 * a5_3;
    J_out[4] = v5_1;
    const double v5_2 = C1 * a5_3;
    J_out[11] = v5_2;
    const double pd2_1 = -d2 * S1;
    const double pd2_2 = d2 * C1;
    const double R2e5_1 = -S1 * S5;
    J_out[5] = -R2e5_1;
    const double R2e5_2 = C1 * S5;
    J_out[12] = -R2e5_2;
    const double pr6_1 = -R6 * R2e5_1 - pd2_1;
    J_out[7] = pr6_1;
    const double pr6_2 = -R6 * R2e5_2 - pd2_2;
    J_out[0] = -pr6_2;
    const double a5_1 = pd2_1 + pr6_1;
    const double a5_2 = pd2_2 + pr6_2;
    const double v5_3 = S1 * a5_1 - C1 * a5_2;
    J_out[18] = v5_3;
}
