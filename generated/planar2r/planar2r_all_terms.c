/* planar2r: mass_matrix, bias_torque, gravity_torque, jacobian and frames in one call, which turns each
 * angle once
 * 23 mul, 10 add, 2 sincos for one sample, as written here.
 */
#include "planar2r.h"
#include "planar2r_math.h"

void planar2r_all_terms(const double q[2], const double qd[2], const double X[4], double M[4], double h[2], double tau[2], double J_out[12], double T_out[32])
{
    M[3] = X[1];
    tau[0] = 0.0;
    tau[1] = 0.0;
    J_out[1] = 0.0;
    J_out[3] = 0.0;
    J_out[4] = 0.0;
    J_out[5] = 0.0;
    J_out[6] = 0.0;
    J_out[7] = 0.0;
    J_out[8] = 0.0;
    J_out[9] = 0.0;
    J_out[10] = 1.0;
    J_out[11] = 1.0;
    T_out[2] = 0.0;
    T_out[3] = 0.0;
    T_out[6] = 0.0;
    T_out[7] = 0.0;
    T_out[8] = 0.0;
    T_out[9] = 0.0;
    T_out[11] = 0.0;
    T_out[12] = 0.0;
    T_out[13] = 0.0;
    T_out[14] = 0.0;
    T_out[18] = 0.0;
    T_out[22] = 0.0;
    T_out[24] = 0.0;
    T_out[25] = 0.0;
    T_out[27] = 0.0;
    T_out[28] = 0.0;
    T_out[29] = 0.0;
    T_out[30] = 0.0;
    T_out[10] = 1.0;
    T_out[15] = 1.0;
    T_out[26] = 1.0;
    T_out[31] = 1.0;
    const planar2r_angles2 q_0 = planar2r_sincos2(q);
    const double C2 = q_0.c[1];
    const double S2 = q_0.s[1];
    const double m2_1e2 = X[2] * C2 - X[3] * S2;
    const double Nbm23d2 = X[1] + planar2r_geometry_L1 * m2_1e2;
    M[1] = Nbm23d2;
    M[2] = Nbm23d2;
    const double xd2_2 = 2.0 * planar2r_geometry_L1 * m2_1e2;
    const double J33d2_2 = X[1] + xd2_2;
    const double J33s1_2 = X[0] + J33d2_2;
    M[0] = J33s1_2;
    const double ZP33d2 = qd[0] * qd[0];
    const double Z1d2 = -planar2r_geometry_L1 * ZP33d2;
    const double Z1e2 = C2 * Z1d2;
    const double Z2e2 = -S2 * Z1d2;
    const double N2_3 = X[2] * Z2e2 - X[3] * Z1e2;
    h[1] = N2_3;
    const double W32 = qd[0] + qd[1];
    const double P332 = W32 * W32;
    const double F2_1 = -X[2] * P332;
    const double F2_2 = -X[3] * P332;
    const double Fb2e2 = C2 * F2_2 + S2 * F2_1;
    const double Nb3d2 = planar2r_geometry_L1 * Fb2e2 + N2_3;
    h[0] = Nb3d2;
    const double C1 = q_0.c[0];
    T_out[0] = C1;
    T_out[5] = C1;
    const double pd2_1 = planar2r_geometry_L1 * C1;
    J_out[2] = pd2_1;
    T_out[19] = pd2_1;
    const double S1 = q_0.s[0];
    T_out[1] = -S1;
    T_out[4] = S1;
    const double pd2_2 = planar2r_geometry_L1 * S1;
    J_out[0] = -pd2_2;
    T_out[23] = pd2_2;
    const double R1e2_1 = C2 * C1 - S2 * S1;
    T_out[16] = R1e2_1;
    T_out[21] = R1e2_1;
    const double R1e2_2 = C2 * S1 + S2 * C1;
    T_out[17] = -R1e2_2;
    T_out[20] = R1e2_2;
}
