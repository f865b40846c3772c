/* puma560: columns of friction torque: out X[p_inertial..p)
 * 6 other for one sample, as written here.
 */
#include "puma560.h"

puma560_IN_SECTION void puma560_friction_torque(const double q[6], const double qd[6], double out[72])
{
    (void)q;
    for (size_t i = 2u; i < 14u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    for (size_t i = 16u; i < 28u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    for (size_t i = 30u; i < 42u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    for (size_t i = 44u; i < 56u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    for (size_t i = 58u; i < 70u; i += 4u) {
        out[i + 0u] = 0.0;
        out[i + 1u] = 0.0;
        out[i + 2u] = 0.0;
        out[i + 3u] = 0.0;
    }
    out[1] = qd[0];
    out[15] = qd[1];
    out[29] = qd[2];
    out[43] = qd[3];
    out[57] = qd[4];
    out[71] = qd[5];
    const double sFS1 = (double)((qd[0] > 0.0) - (qd[0] < 0.0));
    out[0] = sFS1;
    const double sFS2 = (double)((qd[1] > 0.0) - (qd[1] < 0.0));
    out[14] = sFS2;
    const double sFS3 = (double)((qd[2] > 0.0) - (qd[2] < 0.0));
    out[28] = sFS3;
    const double sFS4 = (double)((qd[3] > 0.0) - (qd[3] < 0.0));
    out[42] = sFS4;
    const double sFS5 = (double)((qd[4] > 0.0) - (qd[4] < 0.0));
    out[56] = sFS5;
    const double sFS6 = (double)((qd[5] > 0.0) - (qd[5] < 0.0));
    out[70] = sFS6;
}
