/* Identification on line by the momentum model: panda_JOINTS equations a window.
 *
 * Over a window (t1, t2) the impulse of each motor is the change of its joint's momentum:
 *
 *     integral tau dt = {P(t2) - P(t1) - integral DL dt} X_inertial + integral F dt X_friction
 *
 * with P = dT/dqd and DL = dL/dq, the columns of panda_momentum_regressor, and F those of
 * panda_friction_torque. No acceleration is needed. The rows of all joints take the same weight.
 *
 * Begin a state here; all else is done by the functions of panda_identifier.h.
 */
#ifndef panda_IDENTIFIER_MOMENTUM_H
#define panda_IDENTIFIER_MOMENTUM_H

#include "panda_identifier.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of memory for a window of so many samples, as a constant expression, and as a function. */
#define panda_IDENTIFIER_MOMENTUM_BYTES(window) panda_IDENTIFIER_BYTES_OF(panda_JOINTS, window)
size_t panda_identifier_momentum_size(size_t window);

/* Begin with no data; arguments and result as of panda_identifier_init. */
int panda_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  panda_real forgetting);

#ifdef __cplusplus
}
#endif

#endif
