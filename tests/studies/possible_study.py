"""Perturbed estimates of real robots: is every question whether they are possible answered?

    python tests/studies/possible_study.py emps ur10e 5 --count 100 --out FILE

Each robot of data/ is identified by least squares; a number is the seed of a random arm. The
parameters are perturbed in five ways:

    rounded      the estimate, with relative changes of 1e-9
    limit        the nearest possible parameters, with relative changes of 1e-9
    drawn        draws of the distribution of the estimate
    far          draws with ten times its standard deviations
    robots       parameters of robots: links with random positive definite pseudo-inertias

`unanswered` counts the estimates without links by `link_parameters` with their covariance, and
those whose refusal without covariance gives no reason. `denied` counts the robots, and the
estimates at the limit, that are called impossible. `disproved` counts the links whose
pseudo-inertia is not positive definite by NumPy. What the logs of a robot do not determine has the
largest parameter as its standard deviation.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support import data_folder
from workflow.test_nearest_possible import estimate_near_truth

import symgen
from symgen import names
from symgen.codegen.model import regrouping

#: Robots of data/, and a random arm.
ROBOTS = (
    "acromonk", "aliengo_leg", "dp_c0", "emps", "kr300", "panda30", "tx40", "ur10", "ur10e", "5",
)  # fmt: skip
KINDS = ("rounded", "limit", "drawn", "far", "robots")
#: Smallest eigenvalue of a pseudo-inertia of a robot, relative to its largest.
THIN = 1e-5
REASONS = ("cannot be", "cannot all be")


def pseudo_inertia(link: np.ndarray) -> np.ndarray:
    """The matrix of XX XY XZ YY YZ ZZ MX MY MZ M."""
    XX, XY, XZ, YY, YZ, ZZ, MX, MY, MZ, M = link
    return np.array(
        [[(YY + ZZ - XX) / 2, -XY, -XZ, MX], [-XY, (XX + ZZ - YY) / 2, -YZ, MY],
         [-XZ, -YZ, (XX + YY - ZZ) / 2, MZ], [MX, MY, MZ, M]]
    )  # fmt: skip


def a_robot(model: symgen.Model, size: float, rng: np.random.Generator) -> np.ndarray:
    """Base parameters of random links that get lighter to the tip, and of positive drives."""
    standard = model.base.standard
    values = {p.name: size * rng.uniform(0.01, 0.1) for p in standard}
    count = sum(p.prefix == "M" for p in standard)
    numbers = [p.name[1:] for p in standard if p.prefix == "M"]
    for k, number in enumerate(numbers):
        light = size * 10.0 ** (-2 * k / count)
        length = 10.0 ** rng.uniform(-2, 0)
        A = rng.normal(size=(4, 4)) * [length, length, length, 1.0]
        thin = 10.0 ** rng.uniform(np.log10(THIN), -1)
        P = A.T @ A + thin * np.diag([length**2] * 3 + [1.0])
        P *= light / P[3, 3]
        S = P[:3, :3]
        J = np.trace(S) * np.eye(3) - S
        row = [*J[np.triu_indices(3)], *P[:3, 3], P[3, 3]]
        values |= {f"{name}{number}": x for name, x in zip(names.LINK, row, strict=True)}
    return regrouping(model) @ [values[p.name] for p in standard]


def perturbed(
    model: symgen.Model, X: np.ndarray, near: np.ndarray, C: np.ndarray, count: int
) -> Iterator[tuple[str, np.ndarray]]:
    """Kind and base parameters of each perturbed estimate."""
    rng = np.random.default_rng(0)
    for k in range(count):
        kind = KINDS[k % len(KINDS)]
        if kind in ("rounded", "limit"):
            about = X if kind == "rounded" else near
            yield kind, about * (1 + 1e-9 * rng.standard_normal(len(X)))
        elif kind in ("drawn", "far"):
            size = 1.0 if kind == "drawn" else 10.0
            yield kind, X + size * rng.multivariate_normal(0 * X, C, method="eigh")
        else:
            yield kind, a_robot(model, float(np.abs(X).max()), rng)


def study(model: symgen.Model, X: np.ndarray, C: np.ndarray, count: int) -> dict[str, object]:
    """The counts of one robot."""
    found = Counter(unanswered=0, denied=0, disproved=0)
    try:
        near = symgen.link_parameters(model, X, nearest=C).X
    except symgen.ParameterError:
        near = X
    begun = time.process_time()
    for kind, x in perturbed(model, X, near, C, count):
        found["all"] += 1
        try:
            links = symgen.link_parameters(model, x)
        except symgen.ParameterError as error:
            found[f"impossible {kind}"] += 1
            found["denied"] += kind in ("robots", "limit")
            unanswered = not any(reason in str(error) for reason in REASONS)
        else:
            found[f"possible {kind}"] += 1
            unanswered = False
            found["disproved"] += not are_bodies(links)
        try:
            found["disproved"] += not are_bodies(symgen.link_parameters(model, x, nearest=C))
        except symgen.ParameterError:
            unanswered = True
        found["unanswered"] += unanswered
        found[f"unanswered {kind}"] += unanswered
    return {**found, "seconds_each": round((time.process_time() - begun) / count, 3)}


def are_bodies(links: symgen.LinkParameters) -> bool:
    """Whether all pseudo-inertias are positive definite, and friction and rotors not negative."""
    numbers = [name[1:] for name in links.values if name[0] == "M" and name[1:2] not in "XYZ"]
    rows = [[links.values[f"{name}{number}"] for name in names.LINK] for number in numbers]
    drives = [value for name, value in links.values.items() if name[:2] in ("IA", "FS", "FV")]
    return min(drives, default=0.0) >= 0 and all(
        np.linalg.eigvalsh(pseudo_inertia(np.array(row))).min() > -1e-15 * max(row) for row in rows
    )


def estimate_of(name: str) -> tuple[symgen.Model, np.ndarray, np.ndarray]:
    """Model, base parameters and covariance of a robot of data/ by least squares."""
    if name.isdigit():
        model, _, _, X, C = estimate_near_truth(int(name))
        return model, X, C
    folder = data_folder() / name
    robot = symgen.read_robot(folder / "robot.toml")
    logs = sorted(path for path in folder.iterdir() if path.stem.startswith("train"))
    estimate = symgen.identify(robot, logs, method="wls")
    std = np.sqrt(np.diag(estimate.covariance))
    size = np.where(np.isfinite(std), std, np.abs(estimate.X).max())
    correlation = np.nan_to_num(estimate.correlation)
    np.fill_diagonal(correlation, 1.0)
    return symgen.derive(robot), estimate.X, correlation * np.outer(size, size)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    rows = {}
    for name in given.robots:
        rows[name] = study(*estimate_of(name), given.count)
        print(name, json.dumps(rows[name]), flush=True)
    if given.out:
        given.out.write_text(json.dumps(rows, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
