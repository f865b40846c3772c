/* panda: columns of friction torque: out X[p_inertial..p)
 * 7 other for one sample, as written here.
 */
#include "panda.h"

void panda_friction_torque(const double q[7], const double qd[7], double out[98])
{
    (void)q;
    for (size_t i = 2u; i < 14u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    out[14] = 0.0;
    out[15] = 0.0;
    for (size_t i = 18u; i < 30u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    out[30] = 0.0;
    out[31] = 0.0;
    for (size_t i = 34u; i < 46u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    out[46] = 0.0;
    out[47] = 0.0;
    for (size_t i = 50u; i < 62u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    out[62] = 0.0;
    out[63] = 0.0;
    for (size_t i = 66u; i < 78u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    out[78] = 0.0;
    out[79] = 0.0;
    for (size_t i = 82u; i < 94u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    out[94] = 0.0;
    out[95] = 0.0;
    out[1] = qd[0];
    out[17] = qd[1];
    out[33] = qd[2];
    out[49] = qd[3];
    out[65] = qd[4];
    out[81] = qd[5];
    out[97] = qd[6];
    const double sFS1 = (double)((qd[0] > 0.0) - (qd[0] < 0.0));
    out[0] = sFS1;
    const double sFS2 = (double)((qd[1] > 0.0) - (qd[1] < 0.0));
    out[16] = sFS2;
    const double sFS3 = (double)((qd[2] > 0.0) - (qd[2] < 0.0));
    out[32] = sFS3;
    const double sFS4 = (double)((qd[3] > 0.0) - (qd[3] < 0.0));
    out[48] = sFS4;
    const double sFS5 = (double)((qd[4] > 0.0) - (qd[4] < 0.0));
    out[64] = sFS5;
    const double sFS6 = (double)((qd[5] > 0.0) - (qd[5] < 0.0));
    out[80] = sFS6;
    const double sFS7 = (double)((qd[6] > 0.0) - (qd[6] < 0.0));
    out[96] = sFS7;
}
