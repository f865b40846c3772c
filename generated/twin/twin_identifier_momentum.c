#include "twin_identifier_momentum.h"

#include <string.h>

static void momentum(const twin_real *q, const twin_real *qd, const twin_real *tau,
                     twin_real *value, twin_real *rate)
{
    twin_momentum_regressor(q, qd, value, rate);
    for (int i = 0; i < twin_JOINTS * twin_INERTIAL; i++) {
        rate[i] = -rate[i];
    }
#if twin_PARAMETERS > twin_INERTIAL
    twin_friction_torque(q, qd, rate + twin_JOINTS * twin_INERTIAL);
#endif
    memcpy(rate + twin_JOINTS * twin_PARAMETERS, tau, twin_JOINTS * sizeof *tau);
}

size_t twin_identifier_momentum_size(size_t window)
{
    return twin_identifier_size_of(twin_JOINTS, window);
}

int twin_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  twin_real forgetting)
{
    return twin_identifier_init_of(state, bytes, window, mode, forgetting, twin_JOINTS, momentum);
}
