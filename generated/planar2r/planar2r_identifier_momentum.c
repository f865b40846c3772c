#include "planar2r_identifier_momentum.h"

#include <string.h>

static void momentum(const planar2r_real *q, const planar2r_real *qd, const planar2r_real *tau,
                     planar2r_real *value, planar2r_real *rate)
{
    planar2r_momentum_regressor(q, qd, value, rate);
    for (int i = 0; i < planar2r_JOINTS * planar2r_INERTIAL; i++) {
        rate[i] = -rate[i];
    }
#if planar2r_PARAMETERS > planar2r_INERTIAL
    planar2r_friction_torque(q, qd, rate + planar2r_JOINTS * planar2r_INERTIAL);
#endif
    memcpy(rate + planar2r_JOINTS * planar2r_PARAMETERS, tau, planar2r_JOINTS * sizeof *tau);
}

size_t planar2r_identifier_momentum_size(size_t window)
{
    return planar2r_identifier_size_of(planar2r_JOINTS, window);
}

int planar2r_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  planar2r_real forgetting)
{
    return planar2r_identifier_init_of(state, bytes, window, mode, forgetting, planar2r_JOINTS, momentum);
}
