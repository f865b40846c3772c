#include "puma560_identifier_momentum.h"

#include <string.h>

static void momentum(const puma560_real *q, const puma560_real *qd, const puma560_real *tau,
                     puma560_real *value, puma560_real *rate)
{
    puma560_momentum_regressor(q, qd, value, rate);
    for (int i = 0; i < puma560_JOINTS * puma560_INERTIAL; i++) {
        rate[i] = -rate[i];
    }
#if puma560_PARAMETERS > puma560_INERTIAL
    puma560_friction_torque(q, qd, rate + puma560_JOINTS * puma560_INERTIAL);
#endif
    memcpy(rate + puma560_JOINTS * puma560_PARAMETERS, tau, puma560_JOINTS * sizeof *tau);
}

size_t puma560_identifier_momentum_size(size_t window)
{
    return puma560_identifier_size_of(puma560_JOINTS, window);
}

int puma560_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  puma560_real forgetting)
{
    return puma560_identifier_init_of(state, bytes, window, mode, forgetting, puma560_JOINTS, momentum);
}
