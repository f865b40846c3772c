/* twin: columns of friction torque: out X[p_inertial..p)
 * 7 other for one sample.
 */
#include "twin.h"

void twin_friction_torque(const double *q, const double *qd, double *out)
{
    (void)q;
    const double sFS1 = (double)((qd[0] > 0.0) - (qd[0] < 0.0));
    const double sFS2 = (double)((qd[1] > 0.0) - (qd[1] < 0.0));
    const double sFS3 = (double)((qd[2] > 0.0) - (qd[2] < 0.0));
    const double sFS4 = (double)((qd[3] > 0.0) - (qd[3] < 0.0));
    const double sFS5 = (double)((qd[4] > 0.0) - (qd[4] < 0.0));
    const double sFS6 = (double)((qd[5] > 0.0) - (qd[5] < 0.0));
    const double sFS7 = (double)((qd[6] > 0.0) - (qd[6] < 0.0));
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
    out[14] = 0.0;
    out[15] = 0.0;
    out[16] = sFS2;
    out[17] = qd[1];
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
    out[28] = 0.0;
    out[29] = 0.0;
    out[30] = 0.0;
    out[31] = 0.0;
    out[32] = sFS3;
    out[33] = qd[2];
    out[34] = 0.0;
    out[35] = 0.0;
    out[36] = 0.0;
    out[37] = 0.0;
    out[38] = 0.0;
    out[39] = 0.0;
    out[40] = 0.0;
    out[41] = 0.0;
    out[42] = 0.0;
    out[43] = 0.0;
    out[44] = 0.0;
    out[45] = 0.0;
    out[46] = 0.0;
    out[47] = 0.0;
    out[48] = sFS4;
    out[49] = qd[3];
    out[50] = 0.0;
    out[51] = 0.0;
    out[52] = 0.0;
    out[53] = 0.0;
    out[54] = 0.0;
    out[55] = 0.0;
    out[56] = 0.0;
    out[57] = 0.0;
    out[58] = 0.0;
    out[59] = 0.0;
    out[60] = 0.0;
    out[61] = 0.0;
    out[62] = 0.0;
    out[63] = 0.0;
    out[64] = sFS5;
    out[65] = qd[4];
    out[66] = 0.0;
    out[67] = 0.0;
    out[68] = 0.0;
    out[69] = 0.0;
    out[70] = 0.0;
    out[71] = 0.0;
    out[72] = 0.0;
    out[73] = 0.0;
    out[74] = 0.0;
    out[75] = 0.0;
    out[76] = 0.0;
    out[77] = 0.0;
    out[78] = 0.0;
    out[79] = 0.0;
    out[80] = sFS6;
    out[81] = qd[5];
    out[82] = 0.0;
    out[83] = 0.0;
    out[84] = 0.0;
    out[85] = 0.0;
    out[86] = 0.0;
    out[87] = 0.0;
    out[88] = 0.0;
    out[89] = 0.0;
    out[90] = 0.0;
    out[91] = 0.0;
    out[92] = 0.0;
    out[93] = 0.0;
    out[94] = 0.0;
    out[95] = 0.0;
    out[96] = sFS7;
    out[97] = qd[6];
}

void twin_friction_torque_batch(size_t N, const double *q, const double *qd, double *out)
{
    for (size_t k = 0; k < N; ++k) {
        twin_friction_torque(&q[k * 7u], &qd[k * 7u], &out[k * 98u]);
    }
}
