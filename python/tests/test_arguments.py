"""Arguments that make no sense get an error that names them, and nothing else happens."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import MUNICH

import skyshed
from skyshed import Scene

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

CITY = Scene.itu("urban", size=100)
FLAT = np.zeros((10, 12))
PLACE = (1, 0, 0, 0, -1, 10)
SQUARE = {"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 9], [0, 0]]]}
AT = (50, 50, 60)


def raster(array: Any = FLAT, **said: Any) -> Scene:
    return Scene.from_raster(array, **{"transform": PLACE, **said})


def footprints(buildings: Any, heights: Any = (5,), **said: Any) -> Scene:
    return Scene.from_footprints(buildings, heights, **said)


# What is done, and a word that the error has.
HOSTILE: list[tuple[Callable[[], Any], str]] = [
    # UAVs.
    (lambda: CITY.map((50, 50)), "uav"),  # type: ignore[arg-type]
    (lambda: CITY.map((50, 50, 60, "a", 1)), "uav"),  # type: ignore[arg-type]
    (lambda: CITY.map(None), "uav"),  # type: ignore[arg-type]
    (lambda: CITY.map("50,50,60"), "uav"),  # type: ignore[arg-type]
    (lambda: CITY.map((math.nan, 50, 60)), "uav"),
    (lambda: CITY.map((50, math.inf, 60)), "uav"),
    (lambda: CITY.map((50, 50, math.nan)), "uav"),
    (lambda: CITY.map((50, 50, "high")), "uav"),
    (lambda: CITY.map((50, 50, "")), "uav"),
    (lambda: CITY.map((50, 50, None)), "uav"),  # type: ignore[arg-type]
    (lambda: CITY.map((50, 50, b"60")), "uav"),  # type: ignore[arg-type]
    (lambda: CITY.map((True, 50, 60)), "uav"),
    (lambda: CITY.map(("50", 50, 60)), "uav"),  # type: ignore[arg-type]
    (lambda: CITY.map({"x": 50, "y": 50}), "uav"),
    (lambda: CITY.map({"x": 50, "y": 50, "h": 60, "speed": 3}), "uav"),
    (lambda: CITY.map((1e9, 50, 60)), "UAV"),
    (lambda: CITY.map((50, 50, 1e9)), "UAV"),
    (lambda: CITY.map((50, 50, -1)), "UAV"),
    (lambda: CITY.map(np.zeros((2, 3))), "uav"),
    (lambda: CITY.maps([]), "uavs"),
    (lambda: CITY.maps("abc"), "uavs"),  # type: ignore[arg-type]
    (lambda: CITY.maps([AT, (50, 50)]), "uav"),  # type: ignore[list-item]
    (lambda: CITY.maps(np.zeros(3)), "uavs"),
    (lambda: CITY.maps(np.zeros((3, 2))), "uav"),
    (lambda: CITY.maps([(50, 50, 60, "a"), (60, 60, 60, "a")]), "a"),
    (lambda: CITY.p_los({"x": 1, "y": 2, "h": 3}), "uavs"),  # type: ignore[arg-type]
    (lambda: CITY.p_los([(50, 50, 60), (50, 50, "60 yards")]), "uav"),
    # Options of a map.
    (lambda: CITY.map(AT, radius=-1), "radius"),
    (lambda: CITY.map(AT, radius=0), "radius"),
    (lambda: CITY.map(AT, sector=(10, 10)), "sector"),
    (lambda: CITY.map(AT, sector=90), "sector"),  # type: ignore[arg-type]
    (lambda: CITY.map(AT, elevation=(10, -10)), "elevation"),
    (lambda: CITY.map(AT, beam=0), "beam"),
    (lambda: CITY.map(AT, slant_range=0), "slant range"),
    (lambda: CITY.map(AT, min_radius=-1), "least radius"),
    (lambda: CITY.map({"x": 5, "y": 5, "h": 90, "sector": "north"}), "sector"),
    (lambda: CITY.map({"x": 5, "y": 5, "h": 90, "beam": 400}), "beam"),
    (lambda: CITY.map(AT, radius=math.nan), "radius"),
    (lambda: CITY.map(AT, radius="far"), "radius"),  # type: ignore[arg-type]
    (lambda: CITY.map(AT, radius=[1, 2]), "radius"),  # type: ignore[arg-type]
    (lambda: CITY.map(AT, radius={}), "radius"),  # type: ignore[arg-type]
    (lambda: CITY.map(AT, rx_height=-1), "receivers' height"),
    (lambda: CITY.map(AT, rx_height=math.inf), "rx_height"),
    (lambda: CITY.map(AT, rx_height=1e6), "receivers' height"),
    (lambda: CITY.map(AT, rx_height="1,5"), "rx_height"),  # type: ignore[arg-type]
    (lambda: CITY.map(AT, receivers="water"), "receivers"),
    (lambda: CITY.map(AT, receivers=3), "receivers"),  # type: ignore[arg-type]
    (lambda: CITY.map(AT, layers="los,foo"), "layers"),
    (lambda: CITY.map(AT, layers=[]), "layers"),
    (lambda: CITY.map(AT, layers=[1]), "layers"),  # type: ignore[list-item]
    (lambda: CITY.map(AT, tolerance=2), "tolerance"),
    (lambda: CITY.map(AT, tolerance=math.nan), "tolerance"),
    (lambda: CITY.map(AT, method="guess"), "method"),
    (lambda: CITY.map(AT, method="sweep"), "method"),
    (lambda: CITY.map(AT, zones="yes"), "zones"),  # type: ignore[arg-type]
    (lambda: CITY.map(AT, colour="red"), "colour"),  # type: ignore[call-arg]
    (lambda: CITY.map(AT, ground=15), "ground"),  # type: ignore[call-arg]
    (lambda: CITY.map(AT, output="x.png"), "output"),  # type: ignore[call-arg]
    (lambda: CITY.map(AT, uavs="nope.csv"), "uavs"),  # type: ignore[call-arg]
    (lambda: CITY.map(AT, help=True), "help"),  # type: ignore[call-arg]
    (lambda: CITY.map(AT).save("x.png", radius=3), "radius"),
    (lambda: CITY.place(height=100, extent=(0, 0, 1, 1)), "extent"),
    (lambda: CITY.place(height=100, help=True), "help"),
    (lambda: CITY.place(height=100, within=[3]), "within"),
    (lambda: skyshed.plos(Scene.itu("urban", ground=3), "itu:suburban"), "cities"),
    (lambda: CITY.p_los([(50, 50, 60)], terrain="nope.tif"), "terrain"),  # type: ignore[call-arg]
    # Shares alone have no interval, and three heights are no range.
    (lambda: CITY.p_los([AT], height_error=3), "height_error"),  # type: ignore[call-arg]
    (lambda: CITY.p_los([AT], height_bias=2.0), "height_bias"),  # type: ignore[call-arg]
    (lambda: CITY.map(AT).height_curve((30, 60, 100)), "step"),
    (lambda: CITY.map(AT, progress=3), "progress"),
    (lambda: CITY.map(AT).layer("margin"), "margin"),
    (lambda: CITY.map(AT)["zones"], "zones"),
    (lambda: CITY.height_curve(AT, (100, 10, 1)), "heights"),
    (lambda: CITY.height_curve(AT, (1, 10, 0)), "heights"),
    (lambda: CITY.height_curve(AT, (1, 10)), "heights"),  # type: ignore[arg-type]
    # Arrays.
    (lambda: raster(np.zeros(10)), "surface"),
    (lambda: raster(np.zeros((2, 3, 4))), "surface"),
    (lambda: raster(np.zeros((0, 4))), "surface"),
    (lambda: raster(np.full((3, 3), np.nan)), "array"),
    (lambda: raster(np.full((3, 3), np.inf)), "array"),
    (lambda: raster(np.full((3, 3), 1e9)), "array"),
    (lambda: raster(np.zeros((3, 3), complex)), "surface"),
    (lambda: raster(np.zeros((3, 3), bool)), "surface"),
    (lambda: raster(np.full((3, 3), "5")), "surface"),
    (lambda: raster(np.zeros((3, 3), object)), "surface"),
    (lambda: raster(np.zeros((3, 3), "M8[s]")), "surface"),
    (lambda: raster(np.zeros((3, 3), np.longdouble)), "surface"),
    (lambda: raster([[1, 2], [3]]), ""),
    (lambda: raster(None), "surface"),
    (lambda: raster("dsm.tif"), "surface"),
    (lambda: raster(transform=None), "transform"),
    (lambda: raster(transform=(1, 0, 0, 0, 1, 10)), "transform"),
    (lambda: raster(transform=(-1, 0, 0, 0, -1, 10)), "transform"),
    (lambda: raster(transform=(1, 0.5, 0, 0, -1, 10)), "transform"),
    (lambda: raster(transform=(0, 1, 0, 10, 0, -1)), "transform"),
    (lambda: raster(transform=(1, 0, math.nan, 0, -1, 10)), "transform"),
    (lambda: raster(transform=(1, 0, 0)), "transform"),
    (lambda: raster(transform="north"), "transform"),
    (lambda: raster(transform=(0, 0, 0, 0, 0, 0)), "transform"),
    (lambda: raster(transform=(1e-30, 0, 0, 0, -1e-30, 10)), "transform"),
    (lambda: raster(transform=(1, 0, 1e30, 0, -1, 10)), "transform"),
    (lambda: raster(nodata="none"), "nodata"),
    (lambda: raster(nodata=0), "array"),
    (lambda: raster(crs="EPSG:4326"), "degrees"),
    (lambda: raster(crs="EPSG:99999999"), "crs"),
    (lambda: raster(crs="nonsense"), "crs"),
    (lambda: raster(crs=3.5), "crs"),
    (lambda: raster(crs=[25832]), "crs"),
    (lambda: raster(terrain=np.zeros((3, 3)), terrain_transform=(1, 0, 1e6, 0, -1, 10)), "terrain"),
    (lambda: raster(terrain=np.zeros(3)), "terrain"),
    (lambda: raster(terrain=FLAT, ground=3), "ground"),
    (lambda: raster(terrain="nowhere.tif"), "nowhere.tif"),
    (lambda: raster(ground="low"), "ground"),
    (lambda: raster(ground=1e9), "ground"),
    (lambda: raster(extent=(0, 0, 1, 1)), "extent"),
    (lambda: raster(project="auto"), "project"),
    (lambda: raster(project="nonsense"), "project"),
    (lambda: raster(cell=2), "cell"),
    (lambda: raster(building_threshold=-1, ground=0), "building_threshold"),
    (lambda: raster(nodata_as="wall"), "nodata_as"),
    (lambda: raster(height_field="h"), "height_field"),
    # Footprints.
    (lambda: footprints([SQUARE], [5, 6]), "heights"),
    (lambda: footprints([SQUARE], ["tall"]), "heights"),
    (lambda: footprints([SQUARE], None), "missing"),
    (lambda: footprints([SQUARE], "height"), "heights"),
    (lambda: footprints([SQUARE], [math.inf]), "height"),
    (lambda: footprints([SQUARE], [math.nan]), "height"),
    (lambda: footprints([]), "heights"),
    (lambda: footprints([], []), "buildings"),
    (lambda: footprints([5]), "buildings[0]"),
    (lambda: footprints([{"type": "Point", "coordinates": [0, 0]}]), "buildings[0]"),
    (lambda: footprints([b"no wkb"]), "buildings"),
    (lambda: footprints([SQUARE], crs="EPSG:4326"), "degrees"),
    (lambda: footprints([SQUARE], ids=["a", "b"]), "ids"),
    (lambda: footprints([SQUARE], cell=-1), "cell"),
    (lambda: footprints([SQUARE], extent=(0, 0, 1)), "extent"),
    (lambda: footprints([SQUARE], missing="guess"), "missing"),
    (lambda: footprints([SQUARE], missing="levels"), "missing"),
    # Files and cities.
    (lambda: Scene.open("nowhere.geojson"), "nowhere.geojson"),
    (lambda: Scene.open(""), ""),
    (lambda: Scene.open(MUNICH, height_field="hoehe"), "hoehe"),
    (lambda: Scene.open(MUNICH, size=3), "size"),  # type: ignore[call-arg]
    (lambda: Scene.itu("village"), "village"),
    (lambda: Scene.itu("urban", size=-1), "size"),
    (lambda: Scene.itu("urban", size=math.nan), "size"),
    (lambda: Scene.itu("urban", seed=-1), "seed"),
    (lambda: Scene.itu("urban", seed=1.5), "seed"),  # type: ignore[arg-type]
    # Questions.
    (lambda: CITY.link(AT, (1,)), "rx"),
    (lambda: CITY.link(AT, (math.nan, 1)), "rx"),
    (lambda: CITY.link(AT, "here"), "rx"),
    (lambda: CITY.place(), "height"),
    (lambda: CITY.place(height=100, step=0), "step"),
    (lambda: CITY.place(height=100, count=0), "count"),
    (lambda: CITY.place(height=100, goal="beauty"), "goal"),
    (lambda: CITY.place(height=100, within="nowhere.geojson"), "nowhere.geojson"),
    (lambda: CITY.place(candidates=[(1, 2)]), "uav"),
    (lambda: CITY.place(candidates=[]), "candidates"),
    (lambda: CITY.save("city.txt"), "city.txt"),
    (lambda: raster().save("city.geojson"), "city.geojson"),
    (lambda: CITY.sample({"moon": 3}, height=100), "zones"),
    (lambda: CITY.sample({}, height=100), "zones"),
    (lambda: skyshed.plos(), "scenes"),
    (lambda: skyshed.plos("itu:urban", theta=-5), "elevation angle"),
    (lambda: skyshed.plos("itu:urban", method="magic"), "magic"),
    (lambda: skyshed.plos(raster()), "scenes"),
]


@pytest.mark.parametrize("k", range(len(HOSTILE)))
def test_an_error_names_its_argument(k: int) -> None:
    hostile, name = HOSTILE[k]
    with pytest.raises((skyshed.Error, TypeError, KeyError, ValueError)) as raised:
        hostile()
    text = str(raised.value)
    assert name in text, text
    assert "--" not in text and "panick" not in text and "fault" not in text, text
    if isinstance(raised.value, skyshed.Error):
        assert raised.value.code[0] == "E" and raised.value.code[1:].isdigit()


def test_there_are_at_least_a_hundred() -> None:
    assert len(HOSTILE) >= 100


def test_files_have_errors_of_files(tmp_path: Path) -> None:
    with pytest.raises(OSError) as raised:
        Scene.open("nowhere.tif")
    assert isinstance(raised.value, skyshed.FileError) and isinstance(raised.value, ValueError)
    assert raised.value.code == "E301" and str(raised.value).startswith("E301: ")
    seen = CITY.map(AT)
    seen.save(tmp_path / "los.tif")
    with pytest.raises(skyshed.Error) as again:
        seen.save(tmp_path / "los.tif")
    assert again.value.code == "E106" and again.value.hint
    seen.save(tmp_path / "los.tif", overwrite=True)


def test_warnings_have_a_class_and_a_code() -> None:
    with pytest.warns(skyshed.SkyshedWarning) as told:
        Scene.from_raster(FLAT, transform=PLACE)
    assert any(warning.message.code.startswith("W3") for warning in told)  # type: ignore[union-attr]
    assert all(warning.filename == __file__ for warning in told)
