"""symgen explain on the command line."""

from __future__ import annotations

import click

from symgen.cli.options import effect_names
from symgen.report.terminal import say, table


@click.command()
@click.argument("effect", required=False, shell_complete=effect_names)
def explain(effect: str | None) -> None:
    """Tell what EFFECT is, its formula, what it looks like and how to declare it."""
    from symgen.report.explain import explained, listed

    if effect is None:
        table(("effect", "kind", "what it is"), listed())
    else:
        say(explained(effect))
