"""What a file of buildings means, as Python reads it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import skyshed
from skyshed import Scene


def square(west: float, south: float, side: float, **properties: object) -> dict[str, object]:
    east, north = west + side, south + side
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


def city(folder: Path, *features: dict[str, object]) -> Path:
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    path = folder / "city.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "crs": crs, "features": features}))
    return path


def heights(scene: Scene) -> list[float]:
    """Heights of roofs in the middle of three squares."""
    return [float(scene.link((x, 5, "60amsl"), (x, 5, "0roof"))["receiver"]["height_amsl_m"]) for x in (5.5, 25.5, 45.5)]


@pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")
def test_missing_heights_by_a_list(tmp_path: Path) -> None:
    levels = {"building:levels": 2}
    file = city(tmp_path, square(0, 0, 10, height=10), square(20, 0, 10, height=-1, **levels), square(40, 0, 10))
    with pytest.raises(skyshed.Error) as raised:
        Scene.open(file)
    assert raised.value.code == "E309"
    for missing, wanted in (("levels,median", (6, 10)), (("levels", 9), (6, 9)), (7.5, (7.5, 7.5))):
        scene = Scene.open(file, missing=missing, extent=(0, 0, 50, 10))
        seen = [scene.map((5, 5, "40amsl"), rx_height=0, receivers="roof").receivers, *heights(scene)]
        assert seen == [300, 10, *wanted], missing
    with pytest.raises(skyshed.Error, match="after a number"):
        Scene.open(file, missing=(9, "median"))


@pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")
def test_buildings_in_memory_without_heights() -> None:
    squares = [square(0, 0, 10)["geometry"], square(20, 0, 10)["geometry"], square(40, 0, 10)["geometry"]]
    for none in (np.nan, -1):
        with pytest.raises(skyshed.Error) as raised:
            Scene.from_footprints(squares, [10, 12, none], crs="EPSG:25832")
        assert raised.value.code == "E309"
        scene = Scene.from_footprints(squares, [10, 12, none], crs="EPSG:25832", missing=("median",))
        assert heights(scene) == [10, 12, 10]


@pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")
def test_parts_and_tops_above_the_datum(tmp_path: Path) -> None:
    outline = square(0, 0, 30, building="yes", height=50)
    parts = [square(0, 0, 30, height=12, **{"building:part": "yes"})]
    file = city(tmp_path, outline, *parts)
    place = {"extent": (0, 0, 50, 30)}
    for rule, wanted in (("replace", 12), ("join", 50)):
        scene = Scene.open(file, parts=rule, **place)
        assert scene.link((5, 5, "80amsl"), (5, 5, "0roof"))["receiver"]["height_amsl_m"] == wanted
    file = city(tmp_path, square(0, 0, 10, top=512, foot=500), square(40, 0, 10, top=530, foot=510))
    with pytest.raises(skyshed.Error) as raised:
        Scene.open(file, top_field="top")
    assert raised.value.code == "E365" and "base_field" in (raised.value.hint or "")
    for ground, wanted in ((None, 500), ("buildings", 510), (495, 495)):
        options = {"base_field": "foot"} if ground != 495 else {}
        scene = Scene.open(file, top_field="top", ground=ground, extent=(0, 0, 60, 30), **options)
        link = scene.link((50.5, 5.5, "600amsl"), (50.5, 5.5, 0))
        assert abs(link["receiver"]["height_amsl_m"] - wanted) < 0.01, ground
