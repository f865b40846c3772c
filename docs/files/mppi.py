import json
import sys
import time

import jax
import jax.numpy as jnp

sys.path.insert(0, "panda_jax")
from panda_jax import forward_dynamics, inverse_dynamics

with open("found/estimate.json") as file:
    X = jnp.array([p["value"] for p in json.load(file)["parameters"]])
ROLLOUTS, STEPS, DT = 2048, 30, 0.02  # DT in s
NOISE, TEMPERATURE = 2.0, 0.02  # N m; of the cost
GOAL = jnp.array([0.4, 0.3, -0.3, -1.6, 0.2, 1.9, 0.3])


@jax.jit
def moved(state, tau):
    """Return the state after a step."""
    q, qd = state
    qd = qd + DT * forward_dynamics(q, qd, tau, X)
    return q + DT * qd, qd


@jax.jit
def planned(key, state, torques):
    """Return better torques (STEPS, 7) from rollouts with noise."""
    noise = NOISE * jax.random.normal(key, (STEPS, ROLLOUTS, 7))

    def step(state, tau):
        q, qd = moved(state, tau)
        cost = jnp.sum((q - GOAL) ** 2 + 0.02 * qd**2, axis=-1)
        return (q, qd), cost

    start = tuple(jnp.broadcast_to(x, (ROLLOUTS, 7)) for x in state)
    _, costs = jax.lax.scan(step, start, torques[:, None] + noise)
    weight = jax.nn.softmax(-costs.sum(axis=0) / TEMPERATURE)
    return torques + jnp.einsum("r,trj->tj", weight, noise)


state = GOAL + 0.3, jnp.zeros(7)
held = inverse_dynamics(state[0], 0 * GOAL, 0 * GOAL, X)
torques = jnp.tile(held, (STEPS, 1))
planned(jax.random.key(0), state, torques).block_until_ready()  # compile
moved(state, torques[0])
begun = time.perf_counter()
for key in jax.random.split(jax.random.key(1), 150):
    torques = planned(key, state, torques)
    state = moved(state, torques[0])
    torques = jnp.concatenate([torques[1:], torques[-1:]])
rate = 150 / (time.perf_counter() - begun)
print(f"{rate:.0f} plans a second")
print(f"distance to the goal: {jnp.abs(state[0] - GOAL).max():.2f} rad")
