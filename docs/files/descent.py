import json
import sys

import jax
import jax.numpy as jnp
import numpy as np
from scipy.signal import butter, sosfiltfilt
from scipy.signal.windows import tukey

jax.config.update("jax_enable_x64", True)
sys.path.insert(0, "arm_jax")
from arm_jax import inverse_dynamics

with open("result/estimate.json") as file:
    estimate = json.load(file)
log = np.loadtxt("train.csv", delimiter=",", skiprows=1)
t = log[:, 0]
lowpass = butter(4, estimate["cutoff_hz"], fs=1 / (t[1] - t[0]), output="sos")
filtered = sosfiltfilt(lowpass, log[:, 1:], axis=0)
q, qd, tau = filtered[:, :2], filtered[:, 2:4], filtered[:, 4:]
qdd = np.gradient(qd, t, axis=0)
window = tukey(len(t), 0.1)[:, None]
band = int(estimate["cutoff_hz"] * (t[-1] - t[0]))


def loss(X):
    """Return the squared torque error within the band of the filter."""
    error = inverse_dynamics(q, qd, qdd, X) - tau
    spectrum = jnp.fft.rfft(window * error, axis=0)[:band] / len(t)
    return jnp.sum(spectrum.real**2 + spectrum.imag**2)


@jax.jit
def descended(X, speed):
    """One step of gradient descent with momentum."""
    speed = 0.97 * speed - 0.008 * jax.grad(loss)(X)
    return X + speed, speed


names = [p["name"] for p in estimate["parameters"]]
X = speed = jnp.zeros(len(names))
for _ in range(3000):
    X, speed = descended(X, speed)
found, std = (np.array([p[key] for p in estimate["parameters"]]) for key in ("value", "std"))
largest = np.max(np.abs(X - found) / std)
print(f"largest difference from identify: {largest:.1f} standard deviations")
