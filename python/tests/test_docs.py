"""What the documents show is what happens."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

MODULES = ["skyshed", "skyshed._scene", "skyshed.xarray"]


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name: str) -> None:
    if name == "skyshed.xarray":
        pytest.importorskip("xarray")
    module = importlib.import_module(name)
    found = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS, extraglobs={})
    assert found.attempted > 0 and found.failed == 0


def test_the_guide() -> None:
    pytest.importorskip("xarray")
    guide = Path("docs/python.md").resolve()
    found = doctest.testfile(str(guide), module_relative=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert found.attempted > 20 and found.failed == 0
