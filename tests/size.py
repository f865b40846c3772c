"""Print the lines and the numeric constants of every folder: python tests/size.py [FOLDER].

A constant is a name in capitals to which a module gives a value with a number in it; a tuple or a
table of numbers is one constant of several numbers.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter, defaultdict
from pathlib import Path

_COLUMNS = ("files", "lines", "constants", "numbers")


def numbers(file: Path) -> list[int]:
    """Return how many numbers each numeric constant of a module has."""
    out = []
    for statement in ast.parse(file.read_text("utf-8")).body:
        if not isinstance(statement, (ast.Assign, ast.AnnAssign)) or statement.value is None:
            continue
        targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
        names = {n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name)}
        values = [n.value for n in ast.walk(statement.value) if isinstance(n, ast.Constant)]
        found = sum(type(value) in (int, float) for value in values)
        if found and all(name.isupper() for name in names):
            out.append(found)
    return out


def main(package: Path) -> None:
    """Print a row for each folder of a package, the longest first."""
    rows: dict[str, Counter[str]] = defaultdict(Counter)
    for file in sorted(package.rglob("*.py")):
        found = numbers(file)
        size = Counter(
            files=1,
            lines=len(file.read_text("utf-8").splitlines()),
            constants=len(found),
            numbers=sum(found),
        )
        rows[file.relative_to(package).parts[0]].update(size)
        rows["all"].update(size)
    for folder, row in sorted(rows.items(), key=lambda item: -item[1]["lines"]):
        print(f"{folder:20}", *(f"{row[key]:6} {key}" for key in _COLUMNS))


if __name__ == "__main__":
    root = Path(__file__).resolve().parents[1] / "symgen"
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else root)
