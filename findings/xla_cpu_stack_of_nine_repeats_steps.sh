#!/usr/bin/env bash
# JAX 0.10.2 on a processor: a stack of nine results computes the steps that they share again for each of them.
#
# A chain of joints is a recursion: the position after joint k needs the cosines and sines of all joints before it. XLA's
# compiler for processors computes each cosine once for a stack of up to eight such results. With nine, each result becomes a
# fusion of its own that repeats all steps before it: a chain of 16 joints with nine results computes 108 cosines for each
# state instead of 16. The cost of a regressor or of a mass matrix then grows with the square of
# their size. The program gives the same numbers; only its compiled text shows the repetition.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q jax==0.10.2 jaxlib==0.10.2
JAX_PLATFORMS=cpu "$folder/env/bin/python" - <<'EOF'
import jax
import jax.numpy as jnp

JOINTS = 16


def positions(q, results):
    """Return the last x positions of a planar chain with links of length 1."""
    x, y = jnp.ones_like(q[0]), jnp.zeros_like(q[0])
    out = []
    for angle in q:
        c, s = jnp.cos(angle), jnp.sin(angle)
        x, y = c * x - s * y, s * x + c * y
        out.append(x)
    return jnp.stack(out[-results:], axis=-1)


def cosines(results):
    """Return the number of cosines in the compiled program."""
    q = jnp.ones((JOINTS, 1000))
    text = jax.jit(lambda q: positions(q, results)).lower(q).compile().as_text()
    return text.count(" cosine(")


print("jax", jax.__version__)
for results in (1, 8, 9):
    print(results, "results, cosines:", cosines(results))
assert cosines(8) == JOINTS
assert cosines(9) > 6 * JOINTS, "shared steps are computed once now"
EOF
