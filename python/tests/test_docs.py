"""What the documents show is what happens."""

from __future__ import annotations

import doctest
import importlib
import re
from pathlib import Path

import numpy as np
import pytest

from skyshed import Scene

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

MODULES = ["skyshed", "skyshed._scene", "skyshed.xarray"]


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name: str) -> None:
    if name == "skyshed.xarray":
        pytest.importorskip("xarray")
    module = importlib.import_module(name)
    found = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS, extraglobs={})
    assert found.attempted > 0 and found.failed == 0


def test_codes_are_those_of_the_program() -> None:
    known = set(re.findall(r"^\| ([EW]\d+) \|", Path("docs/codes.md").read_text(encoding="utf-8"), re.M))
    told = {code for path in Path("python/skyshed").glob("*.py") for code in re.findall(r'"([EW]\d{3})"', path.read_text())}
    assert len(known) > 50 and len(told) > 5 and told <= known, told - known


def test_what_is_shown_is_what_single_rays_say() -> None:
    city = Scene.itu("urban", size=300)
    munich, uav = Scene.open("maps/munich.geojson"), (691549.7, 5334762.2, 120)
    for scene, at in [(city, (150, 150, 120)), (munich, uav)]:
        assert np.array_equal(scene.map(at).los, scene.map(at, method="ray").los)


def test_the_guide() -> None:
    pytest.importorskip("xarray")
    guide = Path("docs/python.md").resolve()
    found = doctest.testfile(str(guide), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert found.attempted > 20 and found.failed == 0
