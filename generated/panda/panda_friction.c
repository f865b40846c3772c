/* panda: torque of the friction that joints and couplings declare; effects are not in it
 * 14 mul, 7 add, 7 other for one sample, as written here.
 */
#include "panda.h"

void panda_friction(const double qd[7], const double X[62], double tau[7])
{
    const double sFS1 = (double)((qd[0] > 0.0) - (qd[0] < 0.0));
    const double T1 = qd[0] * X[49] + X[48] * sFS1;
    tau[0] = T1;
    const double sFS2 = (double)((qd[1] > 0.0) - (qd[1] < 0.0));
    const double T2 = qd[1] * X[51] + X[50] * sFS2;
    tau[1] = T2;
    const double sFS3 = (double)((qd[2] > 0.0) - (qd[2] < 0.0));
    const double T3 = qd[2] * X[53] + X[52] * sFS3;
    tau[2] = T3;
    const double sFS4 = (double)((qd[3] > 0.0) - (qd[3] < 0.0));
    const double T4 = qd[3] * X[55] + X[54] * sFS4;
    tau[3] = T4;
    const double sFS5 = (double)((qd[4] > 0.0) - (qd[4] < 0.0));
    const double T5 = qd[4] * X[57] + X[56] * sFS5;
    tau[4] = T5;
    const double sFS6 = (double)((qd[5] > 0.0) - (qd[5] < 0.0));
    const double T6 = qd[5] * X[59] + X[58] * sFS6;
    tau[5] = T6;
    const double sFS7 = (double)((qd[6] > 0.0) - (qd[6] < 0.0));
    const double T7 = qd[6] * X[61] + X[60] * sFS7;
    tau[6] = T7;
}
