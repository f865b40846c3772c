/* Identification on line by the momentum model: puma560_JOINTS equations a window.
 *
 * Over a window (t1, t2) the impulse of each motor is the change of its joint's momentum:
 *
 *     integral tau dt = {P(t2) - P(t1) - integral DL dt} X_inertial + integral F dt X_friction
 *
 * with P = dT/dqd and DL = dL/dq, the columns of puma560_momentum_regressor, and F those of
 * puma560_friction_torque. No acceleration is needed. The rows of all joints take the same weight.
 *
 * Begin a state here; all else is done by the functions of puma560_identifier.h.
 */
#ifndef puma560_IDENTIFIER_MOMENTUM_H
#define puma560_IDENTIFIER_MOMENTUM_H

#include "puma560_identifier.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes of memory for a window of so many samples, as a constant expression, and as a function. */
#define puma560_IDENTIFIER_MOMENTUM_BYTES(window) puma560_IDENTIFIER_BYTES_OF(puma560_JOINTS, window)
size_t puma560_identifier_momentum_size(size_t window);

/* Begin with no data; arguments and result as of puma560_identifier_init. */
int puma560_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  puma560_real forgetting);

#ifdef __cplusplus
}
#endif

#endif
