"""What a hint says is typed in the words of Python, and works."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import towns

import skyshed
from skyshed import Scene

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

#: Cells of 0.0001° near Munich.
DEGREES = (0.0001, 0, 11.5, 0, -0.0001, 48.1)
METERS = (1, 0, 691000, 0, -1, 5334000)


def raster(heights: Any = None, **options: Any) -> Scene:
    placed: dict[str, Any] = {"transform": METERS, **options}
    return Scene.from_raster(towns(2) if heights is None else heights, **placed)


def square(west: float, south: float, edge: float = 10) -> dict[str, Any]:
    x, y = west + edge, south + edge
    return {"type": "Polygon", "coordinates": [[[west, south], [x, south], [x, y], [west, y], [west, south]]]}


def hint_of(asked: Callable[[], Any], code: str) -> str:
    """The hint of a question that is refused: it names no flag."""
    with pytest.raises(skyshed.Error) as raised:
        asked()
    assert raised.value.code == code and raised.value.hint, raised.value
    assert "--" not in raised.value.hint
    hint: str = raised.value.hint
    return hint


def arguments(hint: str, **stand_for: object) -> list[dict[str, Any]]:
    """The arguments that a hint names in backticks, one way after the other; capital letters stand for numbers or texts."""
    ways = []
    for piece in (piece for piece in hint.split("`")[1::2] if "=" in piece):
        name, values = piece.split("=", 1)
        for value in values.split("|") if "|" in values else [values]:
            ways.append(eval(f"dict({name}={value})", {**stand_for}))
    return ways


def test_arrays_in_degrees_come_to_meters(tmp_path: Path) -> None:
    rasterio = pytest.importorskip("rasterio")
    heights = towns(2)
    asked = {"transform": DEGREES, "crs": "EPSG:4326", "ground": -50}
    [auto] = arguments(hint_of(lambda: raster(heights, **asked), "E310"))
    assert auto == {"project": "auto"}
    scene = raster(heights, **asked, **auto)
    assert scene.crs == "EPSG:32632"
    # As a file of the same content is.
    with rasterio.open(
        tmp_path / "degrees.tif", "w", driver="GTiff", width=50, height=40, count=1, dtype="float64", crs="EPSG:4326",
        transform=rasterio.Affine(*DEGREES),
    ) as file:  # fmt: skip
        file.write(heights, 1)
    of_file = Scene.open(tmp_path / "degrees.tif", ground=-50, project="auto")
    west, south, east, north = scene.bounds
    uav = ((west + east) / 2, (south + north) / 2, "90amsl")
    assert of_file.bounds == scene.bounds and of_file.map(uav).digest == scene.map(uav).digest
    coarse = raster(heights, **asked, **auto, cell=20)
    assert coarse.transform.a == 20
    # Over a terrain that is held, in degrees as well.
    below = np.minimum(heights, 3)
    over = raster(heights, transform=DEGREES, crs="EPSG:4326", terrain=below, **auto)
    rasterio.open(
        tmp_path / "below.tif", "w", driver="GTiff", width=50, height=40, count=1, dtype="float64", crs="EPSG:4326",
        transform=rasterio.Affine(*DEGREES),
    ).write(below, 1)  # fmt: skip
    of_files = Scene.open(tmp_path / "degrees.tif", terrain=tmp_path / "below.tif", project="auto")
    assert of_files.map(uav).digest == over.map(uav).digest


def test_what_is_brought_into_another_system_is_said() -> None:
    with pytest.warns(skyshed.SkyshedWarning, match="brought from EPSG:4326 to EPSG:32632"):
        raster(transform=DEGREES, crs="EPSG:4326", project="auto")
    # What is in meters stays, and cells of another size need another system.
    assert raster(crs="EPSG:25832", project="auto").bounds == raster(crs="EPSG:25832").bounds
    with pytest.raises(skyshed.Error, match="E116"):
        raster(crs="EPSG:25832", project="auto", cell=3)
    [named] = arguments(hint_of(lambda: raster(project="auto"), "E310"))
    assert named == {"crs": "EPSG:n"}
    raster(project="auto", crs="EPSG:25832")


def test_dataarrays_in_degrees_come_to_meters() -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("rioxarray")
    import skyshed.xarray  # noqa: F401

    heights = towns(2)
    ys, xs = 48.1 - 0.0001 * (np.arange(40) + 0.5), 11.5 + 0.0001 * (np.arange(50) + 0.5)
    plain = xarray.DataArray(heights, dims=("y", "x"), coords={"y": ys, "x": xs}, name="dsm")
    array = plain.rio.write_crs("EPSG:4326")
    [auto] = arguments(hint_of(lambda: Scene.from_raster(array), "E310"))
    assert Scene.from_raster(array, **auto).crs == "EPSG:32632"
    assert array.skyshed.scene(**auto).crs == "EPSG:32632"
    # Where no system is named, the names of the coordinates say what they are.
    hint = hint_of(lambda: Scene.from_raster(plain.rename(x="lon", y="lat")), "E310")
    both = eval(f"dict({hint.split('`')[1]})")
    assert Scene.from_raster(plain.rename(x="lon", y="lat"), **both).crs == "EPSG:32632"
    # A viewshed lies on the cells that it is asked for.
    for options, code in (({}, "E310"), (auto, "E116")):
        hint = hint_of(lambda: array.skyshed.viewshed(11.502, 48.098, **options), code)
        meters = eval(hint.split("`")[1], {"array": array})
        west, south, east, north = meters.rio.bounds()
        seen = meters.skyshed.viewshed((west + east) / 2, (south + north) / 2, observer_elev=20)
        assert seen.shape == meters.shape and int((seen == 1).sum()) > 0


def test_footprints_in_degrees_and_without_heights() -> None:
    small = [square(11.5, 48.1, 0.0002)]
    [auto] = arguments(hint_of(lambda: Scene.from_footprints(small, [10], crs="EPSG:4326"), "E310"))
    assert Scene.from_footprints(small, [10], crs="EPSG:4326", **auto).crs == "EPSG:32632"
    some = [square(0, 0), square(30, 0), square(60, 0)]
    for missing in (None, "fail"):
        hint = hint_of(lambda: Scene.from_footprints(some, [10, np.nan, np.nan], missing=missing), "E309")
        ways = arguments(hint)
        assert [way["missing"] for way in ways] == ["drop", "median"]
        for way in ways:
            Scene.from_footprints(some, [10, np.nan, np.nan], **way)


def test_places_and_heights_that_are_offered_work() -> None:
    geopandas = pytest.importorskip("geopandas")
    scene = raster(towns(2), ground=0, crs="EPSG:32632")
    # In a house: each height that is offered is one.
    row, col = np.argwhere(towns(2) > 15)[0]
    x, y = 691000 + col + 0.5, 5334000 - row - 0.5
    hint = hint_of(lambda: scene.map((x, y, 80 / 17)), "E201")
    heights = hint.split("`")[1::2]
    assert len(heights) == 2 and all(len(height) <= 8 for height in heights), hint
    for height in heights:
        scene.map((x, y, height))
    # Degrees: points that say so.
    hint = hint_of(lambda: scene.map((11.567, 48.1305, 60)), "E203")
    assert "GeoDataFrame" in hint and "`crs`" in hint
    points = geopandas.GeoDataFrame({"h": [60.0]}, geometry=geopandas.points_from_xy([691010], [5333990]), crs="EPSG:32632").to_crs(4326)
    assert scene.maps(points).p_los[0] > 0
    [swapped] = [piece for piece in hint_of(lambda: scene.map((5333990, 691010, 60)), "E203").split("`")[1::2]]
    scene.map((*map(float, swapped.split(",")), 60))
    [way] = arguments(hint_of(lambda: scene.map((99999, 1, 60)), "E203"), M=50)
    scene.map((99999, 1, 60), **way)


def test_options_are_arguments(tmp_path: Path) -> None:
    city = Scene.itu("urban", size=200)
    at = (100, 100, 100)
    for way in arguments(hint_of(lambda: city.map(at, method="sweep"), "E118")):
        city.map(at, **way)
    both = {"layers": ["los", "margin"], "method": "xdraw"}
    for way in arguments(hint_of(lambda: raster(ground=0).map((691010, 5333990, 60), **both), "E118")):
        raster(ground=0).map((691010, 5333990, 60), **{**both, **way})
    seen = city.map(at)
    seen.save(tmp_path / "seen.tif")
    [way] = arguments(hint_of(lambda: seen.save(tmp_path / "seen.tif"), "E106"))
    assert way == {"overwrite": True}
    seen.save(tmp_path / "seen.tif", **way)
    [way] = arguments(hint_of(lambda: seen.save(tmp_path / "seen.fgb"), "E116"))
    seen.save(tmp_path / "seen.fgb", **way)
    [way] = arguments(hint_of(lambda: city.map(at, tolerance=2), "E113"))
    city.map(at, **way)
    search = {"goal": "p_los>=0.5", "minimize": "height"}
    [way] = arguments(hint_of(lambda: city.place(height=["20", "30amsl"], **search), "E113"))
    city.place(**way, **search, step=100)
    [way] = arguments(hint_of(lambda: city.place(height=60, goal="p_los>=0.5"), "E101"))
    city.place(height=60, goal="p_los>=0.5", step=100, **way)
    alone = raster()
    for way in arguments(hint_of(lambda: alone.map((691010, 5333990, 60), receivers="roof"), "E117"), Z=-20.0):
        terrain = {"terrain": np.minimum(towns(2), 0)} if "terrain" in way else way
        raster(**terrain).map((691010, 5333990, 60), receivers="roof")


def test_a_page_that_is_too_large_says_which_cells_would_fit() -> None:
    scene = Scene.from_raster(np.zeros((4200, 4200), np.int8), transform=METERS, ground=0)
    assert hint_of(scene.live, "E505") == "cells of 1.1 m or more would fit"
