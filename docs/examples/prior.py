"""A short log with a prior

A short motion determines some parameters badly. Here an estimate from an earlier, longer log serves
as a prior, and the standard deviations become smaller.
"""

# ## An earlier estimate
# `symgen.write` puts it into a folder, as the command identify does.

import tempfile

import numpy as np

import symgen

X = np.array([3.5, 0.06, 0.124, 0.006])
seen = symgen.Instruments(encoder_step=1e-4, velocity_noise=2e-3, torque_noise=0.1)
made = symgen.Recording(seen, rate=200.0)
earlier = symgen.simulate("planar2r", X, duration=12.0, seed=1, recording=made).log(0)
fixed = {"model": "momentum", "method": "wls", "cutoff": 4.0}
before = symgen.identify("planar2r", [earlier], **fixed)

# ## A short log

short = symgen.simulate("planar2r", X, duration=4.0, seed=2, recording=made).log(0)
alone = symgen.identify("planar2r", [short], **fixed)
with tempfile.TemporaryDirectory() as folder:
    symgen.write(before, folder)
    both = symgen.identify("planar2r", [short], **fixed, fit=symgen.FitOptions(prior=folder))

# ## Compared
# The intervals are two standard deviations. A prior does not always help: with an earlier log of
# 10 s at 100 Hz, and a short log at 100 Hz, the standard deviation of ZZ1R grows by half.

ratios = []
for p, r, true in zip(alone.parameters, both.parameters, X, strict=True):
    print(f"{p.name:5} {p.value:.3f} +- {2 * p.std:.3f}, with the prior {r.value:.3f} "
          f"+- {2 * r.std:.3f}, true {true}")  # fmt: skip
    ratios.append(p.std / r.std)
print(f"standard deviations are smaller by a factor of at least {min(ratios):.2f}")
assert min(ratios) > 1.5
