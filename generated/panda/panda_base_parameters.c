/* panda: X from the standard parameters, in this order: XX1, XY1, XZ1, YY1, YZ1, ZZ1, MX1, MY1, MZ1, M1,
 * IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, M2, IA2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3,
 * MY3, MZ3, M3, IA3, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, IA4, XX5, XY5, XZ5, YY5,
 * YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6, XZ6, YY6, YZ6, ZZ6, MX6, MY6, MZ6, M6, IA6, XX7,
 * XY7, XZ7, YY7, YZ7, ZZ7, MX7, MY7, MZ7, M7, IA7, FS1, FV1, FS2, FV2, FS3, FV3, FS4, FV4, FS5,
 * FV5, FS6, FV6, FS7, FV7
 * 51 mul, 75 add for one sample, as written here.
 */
#include "panda.h"

void panda_base_parameters(const double standard[91], double X[62])
{
    const double cXX2R_MZ3 = 0.632;
    const double cXX2R_M3 = 0.099856;
    const double cXX2R_M4 = 0.10666225;
    const double cXX3R_M4 = 0.00680625;
    const double cZZ3R_M5 = 0.0136125;
    const double cXX4R_MZ5 = 0.768;
    const double cXX4R_M5 = 0.14064975;
    const double cXY4R_M5 = 0.03168;
    const double cZZ4R_M5 = 0.15426225;
    const double cXX5R_M7 = 0.007744;
    X[2] = standard[12];
    X[3] = standard[13];
    X[4] = standard[15];
    X[6] = standard[17];
    X[10] = standard[24];
    X[11] = standard[26];
    X[15] = standard[32];
    X[18] = standard[35];
    X[19] = standard[37];
    X[23] = standard[43];
    X[25] = standard[45];
    X[26] = standard[46];
    X[27] = standard[48];
    X[29] = standard[50];
    X[31] = standard[54];
    X[34] = standard[57];
    X[35] = standard[59];
    X[39] = standard[65];
    X[41] = standard[67];
    X[42] = standard[68];
    X[43] = standard[70];
    X[44] = standard[71];
    X[45] = standard[72];
    X[46] = standard[73];
    X[47] = standard[76];
    X[48] = standard[77];
    X[49] = standard[78];
    X[50] = standard[79];
    X[51] = standard[80];
    X[52] = standard[81];
    X[53] = standard[82];
    X[54] = standard[83];
    X[55] = standard[84];
    X[56] = standard[85];
    X[57] = standard[86];
    X[58] = standard[87];
    X[59] = standard[88];
    X[60] = standard[89];
    X[61] = standard[90];
    const double NZZ1R = standard[5] + standard[10] + standard[14];
    X[0] = NZZ1R;
    const double NXX2R = standard[11] + standard[25] + standard[30] * cXX2R_MZ3 + standard[31] * cXX2R_M3 + standard[42] * cXX2R_M4 + standard[53] * cXX2R_M4 + standard[64] * cXX2R_M4 + standard[75] * cXX2R_M4 - standard[14];
    X[1] = NXX2R;
    const double NZZ2R = standard[16] + standard[21] + standard[25] + standard[30] * cXX2R_MZ3 + standard[31] * cXX2R_M3 + standard[42] * cXX2R_M4 + standard[53] * cXX2R_M4 + standard[64] * cXX2R_M4 + standard[75] * cXX2R_M4;
    X[5] = NZZ2R;
    const double NMY2R = standard[18] - standard[30] - standard[31] * panda_geometry_R3 - standard[42] * panda_geometry_R3 - standard[53] * panda_geometry_R3 - standard[64] * panda_geometry_R3 - standard[75] * panda_geometry_R3;
    X[7] = NMY2R;
    const double NXX3R = standard[22] + standard[36] - standard[25] - standard[42] * cXX3R_M4;
    X[8] = NXX3R;
    const double NXY3R = standard[23] + standard[41] * panda_geometry_D4;
    X[9] = NXY3R;
    const double NZZ3R = standard[27] + standard[36] + standard[42] * cXX3R_M4 + standard[53] * cZZ3R_M5 + standard[64] * cZZ3R_M5 + standard[75] * cZZ3R_M5;
    X[12] = NZZ3R;
    const double NMX3R = standard[28] + standard[42] * panda_geometry_D4 + standard[53] * panda_geometry_D4 + standard[64] * panda_geometry_D4 + standard[75] * panda_geometry_D4;
    X[13] = NMX3R;
    const double NMY3R = standard[29] - standard[41];
    X[14] = NMY3R;
    const double NXX4R = standard[33] + standard[47] + standard[52] * cXX4R_MZ5 + standard[53] * cXX4R_M5 + standard[64] * cXX4R_M5 + standard[75] * cXX4R_M5 - standard[36];
    X[16] = NXX4R;
    const double NXY4R = standard[34] + standard[52] * panda_geometry_D4 + standard[53] * cXY4R_M5 + standard[64] * cXY4R_M5 + standard[75] * cXY4R_M5;
    X[17] = NXY4R;
    const double NZZ4R = standard[38] + standard[47] + standard[52] * cXX4R_MZ5 + standard[53] * cZZ4R_M5 + standard[64] * cZZ4R_M5 + standard[75] * cZZ4R_M5;
    X[20] = NZZ4R;
    const double NMX4R = standard[39] - standard[53] * panda_geometry_D4 - standard[64] * panda_geometry_D4 - standard[75] * panda_geometry_D4;
    X[21] = NMX4R;
    const double NMY4R = standard[40] + standard[52] + standard[53] * panda_geometry_R5 + standard[64] * panda_geometry_R5 + standard[75] * panda_geometry_R5;
    X[22] = NMY4R;
    const double NXX5R = standard[44] + standard[58] + standard[75] * cXX5R_M7 - standard[47];
    X[24] = NXX5R;
    const double NZZ5R = standard[49] + standard[58] + standard[75] * cXX5R_M7;
    X[28] = NZZ5R;
    const double NMY5R = standard[51] - standard[63];
    X[30] = NMY5R;
    const double NXX6R = standard[55] + standard[69] - standard[58] - standard[75] * cXX5R_M7;
    X[32] = NXX6R;
    const double NXY6R = standard[56] + standard[74] * panda_geometry_D7;
    X[33] = NXY6R;
    const double NZZ6R = standard[60] + standard[69] + standard[75] * cXX5R_M7;
    X[36] = NZZ6R;
    const double NMX6R = standard[61] + standard[75] * panda_geometry_D7;
    X[37] = NMX6R;
    const double NMY6R = standard[62] - standard[74];
    X[38] = NMY6R;
    const double NXX7R = standard[66] - standard[69];
    X[40] = NXX7R;
}
