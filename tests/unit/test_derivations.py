"""A second derivation of a robot reads what the first one kept, and is the same."""

from __future__ import annotations

import gc
import json
from dataclasses import replace

import pytest

import symgen
from symgen.codegen import model as compiler
from symgen.codegen import recipes
from symgen.robot.builtin import library

KERNELS = ("energy_regressor", "friction_power", "torque_regressor", "forward_dynamics")


class DerivedError(Exception):
    """Something was derived."""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def forbid(monkeypatch):
    """From when it is called on, nothing can be derived."""

    def refuse(*_, **__):
        raise DerivedError

    def call():
        monkeypatch.setattr(compiler, "find_base", refuse)
        monkeypatch.setattr(recipes, "RECIPES", dict.fromkeys(recipes.RECIPES, refuse))

    return call


@pytest.mark.parametrize("robot", library())
def test_what_was_kept_is_what_was_derived(robot, forbid):
    first = symgen.derive(robot, KERNELS)
    forbid()
    assert symgen.derive(robot, KERNELS) == first


def test_every_kernel_is_kept(forbid):
    first = symgen.derive("scara", "all")
    forbid()
    second = symgen.derive("scara", "all")
    assert second == first
    assert symgen.generate(second) == symgen.generate(first)


def test_garbage_is_collected_again_after_a_derivation(forbid):
    symgen.derive("planar2r", ("mass_matrix",))
    assert gc.isenabled()
    forbid()
    with pytest.raises(DerivedError):
        symgen.derive("planar2r", ("coriolis",))
    assert gc.isenabled()


def test_kernels_that_were_not_asked_for_before_are_derived():
    symgen.derive("planar2r", ("mass_matrix",))
    both = symgen.derive("planar2r", ("mass_matrix", "coriolis"))
    assert [k.name for k in both.kernels] == ["mass_matrix", "coriolis"]


@pytest.mark.parametrize("change", ["geometry", "friction", "name"])
def test_another_robot_is_derived(change, forbid):
    robot = symgen.read_robot("planar2r")
    symgen.derive(robot, KERNELS)
    forbid()
    joint = replace(robot.joints[0], friction=("viscous",))
    other = {
        "geometry": {"geometry": tuple((n, v + 1) for n, v in robot.geometry)},
        "friction": {"joints": (joint, *robot.joints[1:])},
        "name": {"name": "other"},
    }
    with pytest.raises(DerivedError):
        symgen.derive(replace(robot, **other[change]), KERNELS)


@pytest.mark.parametrize("damage", ["changed", "cut", "writable", "link"])
def test_what_is_no_good_is_derived_anew(damage, cache, forbid, tmp_path):
    symgen.derive("planar2r", ())
    (kept,) = cache.glob("derived-*/derived-base-*.json")
    if damage == "changed":
        kept.write_text(kept.read_text().replace("ZZ1", "ZZ2"))
    elif damage == "cut":
        kept.write_bytes(kept.read_bytes()[:100])
    elif damage == "writable":
        kept.chmod(0o666)
    else:
        kept.rename(tmp_path / "elsewhere")
        kept.symlink_to(tmp_path / "elsewhere")
    forbid()
    with pytest.raises(DerivedError):
        symgen.derive("planar2r", ())
    assert not list(cache.glob("derived-*/derived-base-*.json"))


def test_without_a_folder_models_are_derived_each_time(tmp_path, monkeypatch, forbid):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SYMGEN_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "file"))
    symgen.derive("planar2r")
    forbid()
    with pytest.raises(DerivedError):
        symgen.derive("planar2r")


def test_what_is_kept_is_text_of_numbers_and_names(cache):
    symgen.derive("planar2r")
    kept = list(cache.glob("*/*"))
    assert kept
    for file in kept:
        json.loads(file.read_text("ascii"))
