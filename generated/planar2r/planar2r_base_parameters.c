/* planar2r: X from the standard parameters, in this order: XX1, XY1, XZ1, YY1, YZ1, ZZ1, MX1, MY1, MZ1, M1,
 * XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, M2
 * 1 mul, 1 add for one sample, as written here.
 */
#include "planar2r.h"

planar2r_IN_SECTION void planar2r_base_parameters(const double standard[20], double X[4])
{
    const double cZZ1R_M2 = 0.25;
    X[1] = standard[15];
    X[2] = standard[16];
    X[3] = standard[17];
    const double NZZ1R = standard[5] + standard[19] * cZZ1R_M2;
    X[0] = NZZ1R;
}
