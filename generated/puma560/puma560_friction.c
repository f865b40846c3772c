/* puma560: torque of the friction that joints and couplings declare; effects are not in it
 * 12 mul, 6 add, 6 other for one sample, as written here.
 */
#include "puma560.h"

puma560_IN_SECTION void puma560_friction(const double qd[6], const double X[52], double tau[6])
{
    const double sFS1 = (double)((qd[0] > 0.0) - (qd[0] < 0.0));
    const double sFS2 = (double)((qd[1] > 0.0) - (qd[1] < 0.0));
    const double sFS3 = (double)((qd[2] > 0.0) - (qd[2] < 0.0));
    const double sFS4 = (double)((qd[3] > 0.0) - (qd[3] < 0.0));
    const double sFS5 = (double)((qd[4] > 0.0) - (qd[4] < 0.0));
    const double sFS6 = (double)((qd[5] > 0.0) - (qd[5] < 0.0));
    const double T1 = qd[0] * X[41] + X[40] * sFS1;
    tau[0] = T1;
    const double T2 = qd[1] * X[43] + X[42] * sFS2;
    tau[1] = T2;
    const double T3 = qd[2] * X[45] + X[44] * sFS3;
    tau[2] = T3;
    const double T4 = qd[3] * X[47] + X[46] * sFS4;
    tau[3] = T4;
    const double T5 = qd[4] * X[49] + X[48] * sFS5;
    tau[4] = T5;
    const double T6 = qd[5] * X[51] + X[50] * sFS6;
    tau[5] = T6;
}
