#include "NAME_identifier_momentum.h"

#include <string.h>

static void momentum(const NAME_real *q, const NAME_real *qd, const NAME_real *tau{{ G }},
                     NAME_real *value, NAME_real *rate)
{
    NAME_momentum_regressor(q, qd{{ g }}, value, rate);
    for (int i = 0; i < NAME_JOINTS * NAME_INERTIAL; i++) {
        rate[i] = -rate[i];
    }
#if NAME_PARAMETERS > NAME_INERTIAL
    NAME_friction_torque(q, qd, rate + NAME_JOINTS * NAME_INERTIAL);
#endif
    memcpy(rate + NAME_JOINTS * NAME_PARAMETERS, tau, NAME_JOINTS * sizeof *tau);
}

size_t NAME_identifier_momentum_size(size_t window)
{
    return NAME_identifier_size_of(NAME_JOINTS, window);
}

int NAME_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  NAME_real forgetting)
{
    return NAME_identifier_init_of(state, bytes, window, mode, forgetting, NAME_JOINTS, momentum);
}
