/* puma560: X from the standard parameters, in this order: XX1, XY1, XZ1, YY1, YZ1, ZZ1, MX1, MY1, MZ1, M1,
 * IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, M2, IA2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3,
 * MY3, MZ3, M3, IA3, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, IA4, XX5, XY5, XZ5, YY5,
 * YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6, XZ6, YY6, YZ6, ZZ6, MX6, MY6, MZ6, M6, IA6, FS1,
 * FV1, FS2, FV2, FS3, FV3, FS4, FV4, FS5, FV5, FS6, FV6
 * 42 mul, 60 add for one sample, as written here.
 */
#include "puma560.h"

puma560_IN_SECTION void puma560_base_parameters(const double standard[78], double X[52])
{
    const double cZZ1R_MZ2 = 0.487;
    const double cZZ1R_M2 = 0.05929225;
    const double cZZ1R_MZ3 = 0.3002;
    const double cZZ1R_M3 = 0.20898125;
    const double cZZ1R_M4 = 0.20939334;
    const double cXX2R_M3 = 0.18645124;
    const double cXZ2R_M3 = -0.04033012;
    const double cXX3R_MZ4 = 0.8662;
    const double cXX3R_M4 = 0.18716352;
    const double cXY3R_M4 = -0.00879193;
    const double cZZ3R_M4 = 0.1879877;
    X[2] = standard[12];
    X[4] = standard[15];
    X[7] = standard[18];
    X[10] = standard[24];
    X[11] = standard[26];
    X[15] = standard[32];
    X[17] = standard[34];
    X[18] = standard[35];
    X[19] = standard[37];
    X[21] = standard[39];
    X[23] = standard[43];
    X[25] = standard[45];
    X[26] = standard[46];
    X[27] = standard[48];
    X[29] = standard[50];
    X[31] = standard[54];
    X[33] = standard[56];
    X[34] = standard[57];
    X[35] = standard[59];
    X[36] = standard[60];
    X[37] = standard[61];
    X[38] = standard[62];
    X[39] = standard[65];
    X[40] = standard[66];
    X[41] = standard[67];
    X[42] = standard[68];
    X[43] = standard[69];
    X[44] = standard[70];
    X[45] = standard[71];
    X[46] = standard[72];
    X[47] = standard[73];
    X[48] = standard[74];
    X[49] = standard[75];
    X[50] = standard[76];
    X[51] = standard[77];
    const double NZZ1R = standard[5] + standard[10] + standard[14] + standard[19] * cZZ1R_MZ2 + standard[20] * cZZ1R_M2 + standard[25] + standard[30] * cZZ1R_MZ3 + standard[31] * cZZ1R_M3 + standard[42] * cZZ1R_M4 + standard[53] * cZZ1R_M4 + standard[64] * cZZ1R_M4;
    X[0] = NZZ1R;
    const double NXX2R = standard[11] - standard[14] - standard[31] * cXX2R_M3 - standard[42] * cXX2R_M3 - standard[53] * cXX2R_M3 - standard[64] * cXX2R_M3;
    X[1] = NXX2R;
    const double NXZ2R = standard[13] - standard[30] * puma560_geometry_D3 - standard[31] * cXZ2R_M3 - standard[42] * cXZ2R_M3 - standard[53] * cXZ2R_M3 - standard[64] * cXZ2R_M3;
    X[3] = NXZ2R;
    const double NZZ2R = standard[16] + standard[21] + standard[31] * cXX2R_M3 + standard[42] * cXX2R_M3 + standard[53] * cXX2R_M3 + standard[64] * cXX2R_M3;
    X[5] = NZZ2R;
    const double NMX2R = standard[17] + standard[31] * puma560_geometry_D3 + standard[42] * puma560_geometry_D3 + standard[53] * puma560_geometry_D3 + standard[64] * puma560_geometry_D3;
    X[6] = NMX2R;
    const double NXX3R = standard[22] + standard[36] + standard[41] * cXX3R_MZ4 + standard[42] * cXX3R_M4 + standard[53] * cXX3R_M4 + standard[64] * cXX3R_M4 - standard[25];
    X[8] = NXX3R;
    const double NXY3R = standard[23] + standard[41] * puma560_geometry_D4 + standard[42] * cXY3R_M4 + standard[53] * cXY3R_M4 + standard[64] * cXY3R_M4;
    X[9] = NXY3R;
    const double NZZ3R = standard[27] + standard[36] + standard[41] * cXX3R_MZ4 + standard[42] * cZZ3R_M4 + standard[53] * cZZ3R_M4 + standard[64] * cZZ3R_M4;
    X[12] = NZZ3R;
    const double NMX3R = standard[28] + standard[42] * puma560_geometry_D4 + standard[53] * puma560_geometry_D4 + standard[64] * puma560_geometry_D4;
    X[13] = NMX3R;
    const double NMY3R = standard[29] - standard[41] - standard[42] * puma560_geometry_R4 - standard[53] * puma560_geometry_R4 - standard[64] * puma560_geometry_R4;
    X[14] = NMY3R;
    const double NXX4R = standard[33] + standard[47] - standard[36];
    X[16] = NXX4R;
    const double NZZ4R = standard[38] + standard[47];
    X[20] = NZZ4R;
    const double NMY4R = standard[40] + standard[52];
    X[22] = NMY4R;
    const double NXX5R = standard[44] + standard[58] - standard[47];
    X[24] = NXX5R;
    const double NZZ5R = standard[49] + standard[58];
    X[28] = NZZ5R;
    const double NMY5R = standard[51] - standard[63];
    X[30] = NMY5R;
    const double NXX6R = standard[55] - standard[58];
    X[32] = NXX6R;
}
