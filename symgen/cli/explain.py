"""The command `explain`: an effect of the library."""

from __future__ import annotations

import click

from symgen.cli.options import effect_names
from symgen.report.terminal import say, table


@click.command()
@click.argument("effect", required=False, shell_complete=effect_names)
def explain(effect: str | None) -> None:
    """Explain EFFECT: its formula, and how to declare it. Without EFFECT, list all."""
    from symgen.report.explain import effect_list, explain_effect

    if effect is None:
        table(("effect", "kind", "what it is"), effect_list())
    else:
        say(explain_effect(effect))
