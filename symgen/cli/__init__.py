"""The command line: a module a command, and the group that holds them."""

from symgen.cli.group import cli as cli
from symgen.cli.group import main as main
