import jax.numpy as jnp


def _joined(values, axis):
    """Stack arrays. XLA computes each of them once.

    It fuses stacks of up to 8 arrays with all the steps before them, and repeats these steps for
    each array. It does not fuse a larger stack, and a gather keeps it as it is.
    """
    count = len(values)
    rows = jnp.stack([*values, *values[:1] * (9 - count)], axis)
    places = jnp.arange(count)
    options = {"indices_are_sorted": True, "unique_indices": True, "mode": "clip"}
    return jnp.take(rows, places, axis=axis, **options)


def _turned(angles):
    """Return the cosines and the sines of angles."""
    angles = jnp.broadcast_arrays(*angles)
    rows = _joined([*map(jnp.cos, angles), *map(jnp.sin, angles)], 0)
    found = jnp.unstack(rows, axis=0)
    return found[: len(angles)], found[len(angles) :]

