"""Figures of parameters from several sources: values with error bars, and differences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symgen.data.raw import FloatArray
from symgen.identification.comparison import Comparison
from symgen.identification.estimate import Estimate
from symgen.identification.uses import KNOWN
from symgen.policy import BEYOND
from symgen.report.plots.curves import (
    COLOURS,
    NAMED_AXIS,
    bars,
    empty,
    escape_text,
    styled,
)

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

_SYMBOLS = ("circle", "diamond", "square", "triangle-up", "cross", "x")
_LEAST, _MOST = 0.05, 1.5  # half the height of the ordinate


@dataclass(frozen=True, eq=False)
class _Source:
    """Values (p,) and standard deviations (p,) under one name."""

    name: str
    values: FloatArray
    std: FloatArray


def values(estimate: Estimate) -> Figure:
    """Draw each parameter with 2 std, by the estimate, its prior and other methods, relative."""
    found = estimate.parameters
    own = _Source(estimate.method, estimate.X, np.array([p.std for p in found]))
    others = [] if estimate.prior is None else [estimate.prior]
    others += estimate.comparison
    sources = [own]
    for other in others:
        sources.append(_Source(other.method, *np.array([other.of(p.name) for p in found]).T))
    return _drawn([p.name for p in found], [p.unit for p in found], sources)


def both_values(comparison: Comparison) -> Figure:
    """Draw the common parameters of two estimates with 2 std, relative to the first."""
    pairs = comparison.parameters
    sources = [
        _Source(name, np.array([x.value for x in side]), np.array([x.std for x in side]))
        for name, side in zip("ab", ([p.a for p in pairs], [p.b for p in pairs]), strict=True)
    ]
    return _drawn([p.name for p in pairs], [p.a.unit for p in pairs], sources)


def moved(comparison: Comparison) -> Figure:
    """Draw the differences of parameters in combined standard deviations, hatched above 3."""
    found = comparison.parameters
    sigmas = np.array([p.sigmas for p in found])
    names = (f"within {BEYOND:g}", f"moved: over {BEYOND:g}")
    hover = [f"{p.name}: {p.sigmas:.3g} std" for p in found]
    beyond = np.array([p.moved for p in found])
    figure = bars([p.name for p in found], sigmas, beyond, names, hover, (-BEYOND, BEYOND))
    figure.update_xaxes(title="parameter").update_yaxes(title="difference, combined std")
    return styled(figure, "Difference", 420, min_width=14 * len(found))


def _drawn(names: Sequence[str], units: Sequence[str], sources: Sequence[_Source]) -> Figure:
    """Draw the values of all sources relative to the first one, which is at 1.

    Parameters that are weak in the first source are pale, and do not determine the range.
    """
    first = sources[0].values
    scale = np.where(np.isfinite(first) & (first != 0), first, np.nan)
    figure, reach = empty(), [_LEAST]
    width = 0.5 / max(1, len(sources) - 1)
    weak = ~(sources[0].std <= KNOWN / 100 * np.abs(scale))
    for k, source in enumerate(sources):
        ratio, bar = source.values / scale, 2 * np.abs(source.std / scale)
        given = np.isfinite(ratio) & ~np.isinf(source.std)
        ends = np.abs(ratio - 1) + np.nan_to_num(bar)
        reach += [e for e in ends[given & ~weak].tolist() if e <= _MOST]
        label, told = (
            escape_text(source.name),
            {"legendgroup": f"{k}", "name": escape_text(source.name)},
        )
        colour, symbol = COLOURS[k % len(COLOURS)], _SYMBOLS[k % len(_SYMBOLS)]
        for chosen, opacity in ((given & ~weak, 1.0), (given & weak, 0.25)):
            at = np.flatnonzero(chosen).tolist()
            hover = [
                f"{escape_text(names[i])} by {label}: {source.values[i]:.5g} ± "
                f"{2 * source.std[i]:.3g} {escape_text(units[i])}"
                for i in at
            ]
            spread = {"array": np.nan_to_num(bar[at]), "thickness": 1.3, "width": 3}
            figure.add_scatter(
                x=np.array(at) + (k - (len(sources) - 1) / 2) * width * (len(sources) > 1),
                y=ratio[at],
                error_y={"type": "data", **spread},
                mode="markers",
                opacity=opacity,
                showlegend=opacity == 1.0,
                hovertext=hover,
                hoverinfo="text",
                marker={"color": colour, "size": 6, "symbol": symbol},
                **told,
            )
    half = 1.08 * max(reach)
    ticks = {"tickvals": list(range(len(names))), "ticktext": [escape_text(name) for name in names]}
    figure.update_xaxes(title="parameter", showgrid=False, **NAMED_AXIS, **ticks)
    figure.update_xaxes(range=[-0.7, len(names) - 0.3])
    figure.update_yaxes(title=f"value over that of {escape_text(sources[0].name)}, -")
    figure.update_yaxes(range=[1 - half, 1 + half])
    return styled(figure, "Values", 460, min_width=(6 + 5 * len(sources)) * len(names))
