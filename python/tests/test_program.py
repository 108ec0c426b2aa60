"""The program that comes with the package is the program; pictures and files are those that it makes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from conftest import MUNICH, program

import skyshed
from skyshed import Scene

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

UAV = (691549.7, 5334762.2, 120)


def run(*words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "skyshed", *map(str, words)], capture_output=True, text=True, check=False)


def test_exit_codes_are_documented() -> None:
    assert run("--version").stdout.split() == ["skyshed", run("--version").stdout.split()[1]]
    for code, words in [(0, ["map", "--help"]), (2, ["map"]), (3, ["info", "nowhere.tif"]), (2, [])]:
        assert run(*words).returncode == code, words
    done = run("map", "itu:urban", "--size", 100, "--uav", "30,30,1")
    assert done.returncode == 4 and "error[E20" in done.stderr and "panicked" not in done.stderr


def test_files_are_those_of_the_program(tmp_path: Path) -> None:
    seen = Scene.open(MUNICH).map(UAV)
    seen.save(tmp_path / "a.tif", tmp_path / "a.png", tmp_path / "a.geojson", polygons="los", title="Munich, seen")
    program("map", MUNICH, "--uav", "691549.7,5334762.2,120", "-o", tmp_path / "b.tif")
    rasterio = pytest.importorskip("rasterio")
    with rasterio.open(tmp_path / "a.tif") as ours, rasterio.open(tmp_path / "b.tif") as theirs:
        assert (ours.transform, ours.crs, ours.profile) == (theirs.transform, theirs.crs, theirs.profile)
        assert (ours.read(1) == theirs.read(1)).all()
        assert tuple(seen.transform) == tuple(ours.transform)[:6] and seen.crs == str(ours.crs)
    with pytest.raises(skyshed.Error, match="bare"):
        seen.save(tmp_path / "c.tif", bare=True)


def test_pictures(tmp_path: Path) -> None:
    seen = Scene.itu("urban", size=200).map((100, 100, 80))
    picture: Any = seen.plot()
    assert picture.png.startswith(b"\x89PNG") and seen._repr_png_() == picture.png
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    axes = pyplot.subplots()[1]
    assert seen.plot(axes) is axes and axes.get_legend() is not None
    pyplot.savefig(tmp_path / "axes.png")
    pyplot.close("all")


def test_the_live_page_is_one_file(tmp_path: Path) -> None:
    city = Scene.itu("urban", size=200)
    page = city.live(tmp_path / "live.html", uavs=[(100, 100, 80)])
    assert (tmp_path / "live.html").read_text(encoding="utf-8") == page.html
    assert "<iframe srcdoc=" in page._repr_html_() and "http-equiv" in page.html
    with pytest.raises(skyshed.Error, match="E505"):
        Scene.itu("urban", size=9000).live()
