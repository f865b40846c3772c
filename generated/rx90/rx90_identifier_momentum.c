#include "rx90_identifier_momentum.h"

#include <string.h>

static void momentum(const rx90_real *q, const rx90_real *qd, const rx90_real *tau,
                     rx90_real *value, rx90_real *rate)
{
    rx90_momentum_regressor(q, qd, value, rate);
    for (int i = 0; i < rx90_JOINTS * rx90_INERTIAL; i++) {
        rate[i] = -rate[i];
    }
#if rx90_PARAMETERS > rx90_INERTIAL
    rx90_friction_torque(q, qd, rate + rx90_JOINTS * rx90_INERTIAL);
#endif
    memcpy(rate + rx90_JOINTS * rx90_PARAMETERS, tau, rx90_JOINTS * sizeof *tau);
}

size_t rx90_identifier_momentum_size(size_t window)
{
    return rx90_identifier_size_of(rx90_JOINTS, window);
}

int rx90_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  rx90_real forgetting)
{
    return rx90_identifier_init_of(state, bytes, window, mode, forgetting, rx90_JOINTS, momentum);
}
