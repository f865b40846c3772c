#include "panda_identifier_momentum.h"

#include <string.h>

static void momentum(const panda_real *q, const panda_real *qd, const panda_real *tau,
                     panda_real *value, panda_real *rate)
{
    panda_momentum_regressor(q, qd, value, rate);
    for (int i = 0; i < panda_JOINTS * panda_INERTIAL; i++) {
        rate[i] = -rate[i];
    }
#if panda_PARAMETERS > panda_INERTIAL
    panda_friction_torque(q, qd, rate + panda_JOINTS * panda_INERTIAL);
#endif
    memcpy(rate + panda_JOINTS * panda_PARAMETERS, tau, panda_JOINTS * sizeof *tau);
}

size_t panda_identifier_momentum_size(size_t window)
{
    return panda_identifier_size_of(panda_JOINTS, window);
}

int panda_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  panda_real forgetting)
{
    return panda_identifier_init_of(state, bytes, window, mode, forgetting, panda_JOINTS, momentum);
}
