/* rx90: columns of friction torque: out X[p_inertial..p)
 * 6 other for one sample.
 */
#include "rx90.h"

void rx90_friction_torque(const double *q, const double *qd, double *out)
{
    (void)q;
    const double sFS1 = (double)((qd[0] > 0.0) - (qd[0] < 0.0));
    const double sFS2 = (double)((qd[1] > 0.0) - (qd[1] < 0.0));
    const double sFS3 = (double)((qd[2] > 0.0) - (qd[2] < 0.0));
    const double sFS4 = (double)((qd[3] > 0.0) - (qd[3] < 0.0));
    const double sFS5 = (double)((qd[4] > 0.0) - (qd[4] < 0.0));
    const double sFS6 = (double)((qd[5] > 0.0) - (qd[5] < 0.0));
    out[0] = sFS1;
    out[1] = qd[0];
    out[2] = 0.0;
    out[3] = 0.0;
    out[4] = 0.0;
    out[5] = 0.0;
    out[6] = 0.0;
    out[7] = 0.0;
    out[8] = 0.0;
    out[9] = 0.0;
    out[10] = 0.0;
    out[11] = 0.0;
    out[12] = 0.0;
    out[13] = 0.0;
    out[14] = sFS2;
    out[15] = qd[1];
    out[16] = 0.0;
    out[17] = 0.0;
    out[18] = 0.0;
    out[19] = 0.0;
    out[20] = 0.0;
    out[21] = 0.0;
    out[22] = 0.0;
    out[23] = 0.0;
    out[24] = 0.0;
    out[25] = 0.0;
    out[26] = 0.0;
    out[27] = 0.0;
    out[28] = sFS3;
    out[29] = qd[2];
    out[30] = 0.0;
    out[31] = 0.0;
    out[32] = 0.0;
    out[33] = 0.0;
    out[34] = 0.0;
    out[35] = 0.0;
    out[36] = 0.0;
    out[37] = 0.0;
    out[38] = 0.0;
    out[39] = 0.0;
    out[40] = 0.0;
    out[41] = 0.0;
    out[42] = sFS4;
    out[43] = qd[3];
    out[44] = 0.0;
    out[45] = 0.0;
    out[46] = 0.0;
    out[47] = 0.0;
    out[48] = 0.0;
    out[49] = 0.0;
    out[50] = 0.0;
    out[51] = 0.0;
    out[52] = 0.0;
    out[53] = 0.0;
    out[54] = 0.0;
    out[55] = 0.0;
    out[56] = sFS5;
    out[57] = qd[4];
    out[58] = 0.0;
    out[59] = 0.0;
    out[60] = 0.0;
    out[61] = 0.0;
    out[62] = 0.0;
    out[63] = 0.0;
    out[64] = 0.0;
    out[65] = 0.0;
    out[66] = 0.0;
    out[67] = 0.0;
    out[68] = 0.0;
    out[69] = 0.0;
    out[70] = sFS6;
    out[71] = qd[5];
}

void rx90_friction_torque_batch(size_t N, const double *q, const double *qd, double *out)
{
    for (size_t k = 0; k < N; ++k) {
        rx90_friction_torque(&q[k * 6u], &qd[k * 6u], &out[k * 72u]);
    }
}
