"""The command line: one module for each command, and the group that contains them."""

from symgen.cli.group import cli as cli
from symgen.cli.group import main as main
