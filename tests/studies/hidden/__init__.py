"""Logs of robots in which an effect is hidden, from simulators of their own.

Nothing here imports the package under test: the rigid bodies are Pinocchio's or MuJoCo's, friction,
effects, controller and integrator are written here and in oracles/hidden. `cases` holds the door:
`case`, `cases`, `write`.

What is simpler than a real robot: the controller is continuous and sees true positions; Coulomb
friction is tanh(qd/width) with the width that robot.toml declares; a contact comes at the same time
in both logs; thermal drift starts anew with each log; only the torque channel saturates; a delay
shifts the torque channel.
Sizes are set along the training reference. Friction shakes an elastic joint, whose share then comes
out up to twice as large; the other effects keep theirs to about a tenth, but for rare cases. An
error of a tachometer is no missing torque: its size is a share of the speed, its gap is zero. A
torque that saturates in training may stay within its limit in validation.
"""
