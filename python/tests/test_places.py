"""Places in tables, of geopandas in any reference system, and what the package itself answered."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import MUNICH

import skyshed
from skyshed import Scene

geopandas = pytest.importorskip("geopandas")
pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

XY = [(691549.7, 5334762.2), (691600.0, 5334700.0), (691500.0, 5334800.0), (691420.0, 5334690.0)]


def points(**columns: object) -> geopandas.GeoDataFrame:
    xs, ys = zip(*XY)
    return geopandas.GeoDataFrame(columns, geometry=geopandas.points_from_xy(xs, ys), crs="EPSG:25832")


def test_tables_and_points_are_as_tuples() -> None:
    munich = Scene.open(MUNICH)
    wanted = munich.p_los([(x, y, 120) for x, y in XY])
    table = points(h=[120.0] * 4, id=list("abcd"))
    assert np.array_equal(munich.p_los(table), wanted)
    assert np.array_equal(munich.p_los(np.array([(x, y, 120) for x, y in XY])), wanted)
    assert munich.maps(table).ids == list("abcd")
    # Another system of the same plane, a millimeter off at most.
    assert np.allclose(munich.p_los(table.to_crs(25833)), wanted, atol=1e-3)
    assert np.allclose(munich.p_los(table.to_crs(4326)), wanted, atol=1e-3)
    pandas = pytest.importorskip("pandas")
    plain = pandas.DataFrame({"x": [x for x, _ in XY], "y": [y for _, y in XY], "h": "120agl"})
    assert np.array_equal(munich.p_los(plain), wanted)
    with pytest.raises(skyshed.Error, match="column h"):
        munich.p_los(points())


def test_places_in_a_system_need_a_scene_in_one() -> None:
    block = Scene.from_raster(np.zeros((50, 50)), transform=(1, 0, 0, 0, -1, 50), ground=0)
    with pytest.raises(skyshed.Error, match="no reference system"):
        block.p_los(points(h=[30.0] * 4).to_crs(4326))
    with pytest.raises(skyshed.Error, match="no reference system"):
        block.place(height=30, within=points().to_crs(4326))


def test_heights_go_by_their_index() -> None:
    table = geopandas.read_file(MUNICH).set_crs("EPSG:25832", allow_override=True)
    wanted = Scene.from_footprints(table).p_los([(*XY[0], 120)])
    assert np.array_equal(Scene.from_footprints(table, table["height"].iloc[::-1]).p_los([(*XY[0], 120)]), wanted)


def test_areas_may_have_any_column() -> None:
    munich = Scene.open(MUNICH)
    area = points(when=np.array(["2026-01-01"] * 4, dtype="M8[s]")).to_crs(25832)
    area["geometry"] = area.buffer(50)
    assert munich.place(height=100, step=50, within=area)["winner"] == munich.place(height=100, step=50, within=list(area.geometry))["winner"]


def test_candidates_need_no_height_of_their_own() -> None:
    munich = Scene.open(MUNICH)
    by_tuples = munich.place(candidates=[(x, y, 100) for x, y in XY], radius=300)
    for given in [points(), points(h=[7.0] * 4), points().geometry, points().to_crs(4326)]:
        found = munich.place(candidates=given, height=100, radius=300)
        assert found["winner"]["p_los"] == pytest.approx(by_tuples["winner"]["p_los"], abs=1e-3)
    with pytest.raises(skyshed.Error, match="candidates"):
        munich.place(candidates=points().iloc[:0], height=100)


def test_areas_are_brought_into_the_system_of_the_scene() -> None:
    munich = Scene.open(MUNICH)
    area = points().buffer(60).union_all()
    here = geopandas.GeoSeries([area], crs="EPSG:25832")
    wanted = munich.place(height=100, step=50, within=area)["winner"]
    for given in [here, here.to_crs(4326), here.to_crs(25833)]:
        assert munich.place(height=100, step=50, within=given)["winner"]["x"] == wanted["x"]


def test_what_was_answered_can_be_asked_again() -> None:
    munich = Scene.open(MUNICH)
    found = munich.place(height=[80, 120], step=100, count=2, radius=300)
    chosen = found.table[found.table["kind"] == "chosen"]
    both = munich.maps(chosen, radius=300)
    assert both.which.shape == both.shape and int((both.which == 3).sum()) == int((both.count == 2).sum())
    assert len(chosen) == 2 and munich.maps(chosen, radius=300).p_los.shape == (2,)
    assert munich.maps(found.to_dataframe().query("kind == 'chosen'"), radius=300).to_xarray()["count"].max() >= 1


def test_scenes_are_written(tmp_path: Path) -> None:
    munich = Scene.from_footprints(geopandas.read_file(MUNICH).set_crs("EPSG:25832", allow_override=True))
    munich.save(tmp_path / "city.geojson", tmp_path / "city.xml", tmp_path / "city.tif")
    uav = (*XY[0], 120)
    assert Scene.open(tmp_path / "city.geojson", extent=munich.bounds).map(uav).receivers > 0
    assert (tmp_path / "city.xml").exists() and Scene.open(tmp_path / "city.tif").shape == munich.shape


def test_candidates_and_areas_in_memory_leave_no_path_in_the_document() -> None:
    munich = skyshed.Scene.open(MUNICH)
    x, y = XY[0]
    area = {"type": "Polygon", "coordinates": [[(x - 90, y - 90), (x + 90, y - 90), (x + 90, y + 90), (x - 90, y - 90)]]}
    ask = {"candidates": [(x, y, 100) for x, y in XY], "area": area, "goal": "p_los(area)"}
    first, second = (munich.place(**ask, radius=300) for _ in range(2))
    assert [first[key] for key in ("command", "scene", "digest")] == [second[key] for key in ("command", "scene", "digest")]
    assert {"candidates.csv", "area.geojson"} <= {source["path"] for source in first["scene"]["sources"]}
    assert all(len(source["sha256"]) == 64 for source in first["scene"]["sources"])
