"""A torque with the wrong sign

A drive can record its torque with the opposite sign. The diagnosis then says that no possible robot
moves like this, and that one should check the signs.
"""

# ## Two logs
# The torque of joint 2 has the wrong sign in both.

import symgen

X = [3.5, 0.06, 0.124, 0.006]
seen = symgen.Instruments(encoder_step=1e-4, velocity_noise=2e-3, torque_noise=0.02)
made = symgen.Recording(seen, rate=200.0)
done = symgen.simulate("planar2r", X, duration=5.0, runs=2, seed=1, recording=made)


def turned(run):
    """Return the log of a run with the torque of joint 2 turned round."""
    log = done.log(run)
    return symgen.make_log(log.name, log.t, log.q, log.tau * [1, -1], log.qd)


# ## The diagnosis
# Its advice has the torque error of the nearest possible robot.

why = symgen.diagnose("planar2r", [turned(0)], validation=[turned(1)])
print("diagnose:", why.verdict)
print("\n".join(why.advice))

# ## The correct sign
# The same two logs, as the joint really moved.

mended = symgen.identify("planar2r", [done.log(0)], validation=[done.log(1)], model="energy")
error = 100 * mended.torque_validation.relative
print(f"with the correct sign: {mended.verdict}, torque error {error:.3f} %")
assert why.verdict == "bad-measurement"
assert error < 1.0
