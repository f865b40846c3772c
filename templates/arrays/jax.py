{% set title = "JAX" %}
{% set needs = "jax, and nothing else" %}
{% set transforms = "jit, vmap and grad apply to the functions, also by X." %}
{% macro converted(names) %}{{ names | join(", ") }}{{ "," if names | length == 1 }} = map(jnp.asarray, ({{ names | join(", ") }},)){% endmacro %}
{% macro entries(name) %}jnp.unstack({{ name }}, axis=-1){% endmacro %}
{% macro head() %}
import jax.numpy as jnp


def _joined(values, axis, places=None):
    """Stack arrays, and take the rows at these places. XLA computes each array once.

    XLA fuses stacks of up to 8 arrays with all the steps before them, and repeats these steps for
    each array. It does not fuse a larger stack, and a gather keeps it as it is.
    """
    count = len(values)
    rows = jnp.stack([*values, *values[:1] * (9 - count)], axis)
    places = jnp.arange(count) if places is None else jnp.array(places)
    return jnp.take(rows, places, axis=axis, mode="clip")


def _turned(angles):
    """Return the cosines and the sines of angles."""
    angles = jnp.broadcast_arrays(*angles)
    rows = _joined([*map(jnp.cos, angles), *map(jnp.sin, angles)], 0)
    found = jnp.unstack(rows, axis=0)
    return found[: len(angles)], found[len(angles) :]


def _kept(values):
    """Return arrays that XLA computes before what follows: it repeats steps in long fusions."""
    rows = _joined(jnp.broadcast_arrays(*values), 0)
    return jnp.unstack(rows, axis=0)
{% endmacro %}
