/* puma560: columns of the power that friction takes: P = out . X[p_inertial..p)
 * 6 mul, 6 other for one sample, as written here.
 */
#include "puma560.h"

#include <math.h>

puma560_IN_SECTION void puma560_friction_power(const double q[6], const double qd[6], double out[12])
{
    (void)q;
    const double DFS1 = fabs(qd[0]);
    out[0] = DFS1;
    const double DFV1 = qd[0] * qd[0];
    out[1] = DFV1;
    const double DFS2 = fabs(qd[1]);
    out[2] = DFS2;
    const double DFV2 = qd[1] * qd[1];
    out[3] = DFV2;
    const double DFS3 = fabs(qd[2]);
    out[4] = DFS3;
    const double DFV3 = qd[2] * qd[2];
    out[5] = DFV3;
    const double DFS4 = fabs(qd[3]);
    out[6] = DFS4;
    const double DFV4 = qd[3] * qd[3];
    out[7] = DFV4;
    const double DFS5 = fabs(qd[4]);
    out[8] = DFS5;
    const double DFV5 = qd[4] * qd[4];
    out[9] = DFV5;
    const double DFS6 = fabs(qd[5]);
    out[10] = DFS6;
    const double DFV6 = qd[5] * qd[5];
    out[11] = DFV6;
}
