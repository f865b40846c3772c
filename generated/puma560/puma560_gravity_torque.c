/* puma560: torque of gravity on the links, without springs and friction
 * 50 mul, 28 add, 5 sincos for one sample, as written here.
 */
#include "puma560.h"
#include "puma560_math.h"

puma560_IN_SECTION void puma560_gravity_torque(const double q[6], const double X[40], double tau[6])
{
    const double gz = 9.81;
    const puma560_angles4 q_1 = puma560_sincos4(&q[1]);
    const puma560_angles1 q_5 = puma560_sincos1(&q[5]);
    const double C2 = q_1.c[0];
    const double S2 = q_1.s[0];
    const double C3 = q_1.c[1];
    const double S3 = q_1.s[1];
    const double C4 = q_1.c[2];
    const double S4 = q_1.s[2];
    const double C5 = q_1.c[3];
    const double S5 = q_1.s[3];
    const double C6 = q_5.c[0];
    const double S6 = q_5.s[0];
    const double Z1e2 = -gz * S2;
    const double Z2e2 = -gz * C2;
    const double Z1e3 = C3 * Z1e2 + S3 * Z2e2;
    const double Z2e3 = C3 * Z2e2 - S3 * Z1e2;
    const double Z1e4 = C4 * Z1e3;
    const double Z2e4 = -S4 * Z1e3;
    const double Z1e5 = C5 * Z1e4 + S5 * Z2e3;
    const double Z2e5 = C5 * Z2e3 - S5 * Z1e4;
    const double Z1e6 = C6 * Z1e5 + S6 * Z2e4;
    const double Z2e6 = C6 * Z2e4 - S6 * Z1e5;
    const double N2_3 = X[6] * Z2e2 - X[7] * Z1e2;
    const double N3_3 = X[13] * Z2e3 - X[14] * Z1e3;
    const double N4_1 = -X[22] * Z2e3;
    const double N4_2 = X[21] * Z2e3;
    const double N4_3 = X[21] * Z2e4 - X[22] * Z1e4;
    const double N5_1 = X[30] * Z2e4;
    const double N5_2 = -X[29] * Z2e4;
    const double N5_3 = X[29] * Z2e5 - X[30] * Z1e5;
    const double N6_1 = -X[38] * Z2e5;
    const double N6_2 = X[37] * Z2e5;
    const double N6_3 = X[37] * Z2e6 - X[38] * Z1e6;
    tau[5] = N6_3;
    const double Nb1e6 = C6 * N6_1 - S6 * N6_2;
    const double Nb2e6 = C6 * N6_2 + S6 * N6_1;
    const double Ns5_6_1 = N5_1 + Nb1e6;
    const double Ns5_6_2 = N5_2 - N6_3;
    const double Ns5_6_3 = N5_3 + Nb2e6;
    tau[4] = Ns5_6_3;
    const double Nb1e5 = C5 * Ns5_6_1 - S5 * Ns5_6_2;
    const double Nb2e5 = C5 * Ns5_6_2 + S5 * Ns5_6_1;
    const double Ns4_5_1 = N4_1 + Nb1e5;
    const double Ns4_5_2 = N4_2 + Ns5_6_3;
    const double Ns4_5_3 = N4_3 - Nb2e5;
    tau[3] = Ns4_5_3;
    const double Nb1e4 = C4 * Ns4_5_1 - S4 * Ns4_5_2;
    const double Nb2e4 = C4 * Ns4_5_2 + S4 * Ns4_5_1;
    const double Ns3_4_3 = N3_3 + Nb2e4;
    tau[2] = Ns3_4_3;
    const double Nb1e3 = C3 * Nb1e4 + S3 * Ns4_5_3;
    const double Nb2e3 = S3 * Nb1e4 - C3 * Ns4_5_3;
    const double Ns2_3_3 = N2_3 + Ns3_4_3;
    tau[1] = Ns2_3_3;
    const double Nb2e2 = C2 * Nb2e3 + S2 * Nb1e3;
    tau[0] = -Nb2e2;
}
