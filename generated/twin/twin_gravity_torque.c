/* twin: torque that holds the arm at rest, without friction
 * 45 mul, 23 add, 5 sincos for one sample, as written here.
 */
#include "twin.h"
#include "twin_math.h"

void twin_gravity_torque(const double q[7], const double X[44], double tau[7])
{
    const double d3 = 0.3;
    const double gz = 9.81;
    const twin_angles4 q_1 = twin_sincos4(&q[1]);
    const twin_angles1 q_6 = twin_sincos1(&q[6]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double C3 = q_1.c[1];
    const double S3 = q_1.s[1];
    const double C4 = q_1.c[2];
    const double S4 = q_1.s[2];
    const double C5 = q_1.c[3];
    const double S5 = q_1.s[3];
    const double R6 = q[5] + d3;
    const double C7 = q_6.c[0];
    const double S7 = q_6.s[0];
    const double Z1e2 = gz * S2;
    const double Z2e2 = gz * C2;
    const double Z1e3 = C3 * Z1e2 + S3 * Z2e2;
    const double Z2e3 = C3 * Z2e2 - S3 * Z1e2;
    const double N2_3 = X[6] * Z2e2 - X[7] * Z1e2;
    const double Z1e4 = C4 * Z1e3;
    const double Z2e4 = -S4 * Z1e3;
    const double N3_3 = X[13] * Z2e3 - X[14] * Z1e3;
    const double N4_3 = X[21] * Z2e4 - X[22] * Z1e4;
    tau[3] = N4_3;
    const double Z1e5 = gz * S5;
    const double Z2e5 = gz * C5;
    const double F6_3 = -X[34] * Z2e5;
    tau[5] = F6_3;
    const double Z1e7 = C7 * Z1e5 + S7 * Z2e5;
    const double Z2e7 = C7 * Z2e5 - S7 * Z1e5;
    const double N7_3 = X[41] * Z2e7 - X[42] * Z1e7;
    tau[6] = N7_3;
    const double N4_1 = -X[22] * Z2e3;
    const double N4_2 = X[21] * Z2e3;
    const double N5_3 = X[29] * Z2e5 - X[30] * Z1e5;
    const double F6_1 = X[34] * Z1e5;
    const double N6_1 = -X[32] * Z2e5;
    const double N6_2 = X[31] * Z2e5 + X[33] * Z1e5;
    const double N6_3 = -X[32] * Z1e5;
    const double Ns6_7_2 = N6_2 + N7_3;
    const double Nb2r6 = R6 * F6_1 + Ns6_7_2;
    const double Ns5_6_3 = N5_3 + Nb2r6;
    tau[4] = Ns5_6_3;
    const double Nb2e5 = S5 * N6_1 - C5 * N6_3;
    const double Nb1e4 = C4 * N4_1 - S4 * N4_2;
    const double Nb2e4 = C4 * N4_2 + S4 * N4_1;
    const double Ns3_4_3 = N3_3 + Nb2e4;
    tau[2] = Ns3_4_3;
    const double Ns2_3_3 = N2_3 + Ns3_4_3;
    tau[1] = Ns2_3_3;
    const double Nb1e3 = C3 * Nb1e4 + S3 * N4_3;
    const double Nb2e3 = S3 * Nb1e4 - C3 * N4_3;
    const double Nb2e2 = C2 * Nb2e3 + S2 * Nb1e3;
    const double Ns1_2_3 = Nb2e5 + Nb2e2;
    tau[0] = Ns1_2_3;
}
