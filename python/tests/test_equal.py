"""Answers of the package are those of the program, whatever way the scene came in."""

from __future__ import annotations

import importlib.util
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import LONG, MUNICH, program, shared_data, towns

import skyshed
from skyshed import Scene

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

WEST, NORTH, CELL = 1000.25, 5000.5, 2.0
PLACE = (CELL, 0, WEST, 0, -CELL, NORTH)


def ascii_grid(path: Path, heights: np.ndarray[Any, Any]) -> Path:
    """Writes heights as an Esri ASCII grid."""
    n_rows, n_cols = heights.shape
    head = f"ncols {n_cols}\nnrows {n_rows}\nxllcorner {WEST!r}\nyllcorner {NORTH - CELL * n_rows!r}\ncellsize {CELL!r}\n"
    rows = [" ".join("-9999" if np.isnan(h) else repr(float(h)) for h in row) for row in heights]
    path.write_text(head + "NODATA_value -9999\n" + "\n".join(rows) + "\n")
    return path


def asked(seed: int) -> tuple[tuple[float, float, str], dict[str, Any], list[str]]:
    """A UAV and options as both are told."""
    random = np.random.default_rng(seed + 1000)
    uav = (float(WEST + random.uniform(5, 90)), float(NORTH - random.uniform(5, 70)), f"{random.uniform(45, 90)!r}amsl")
    options: dict[str, Any] = {"rx_height": float(random.integers(0, 4))}
    if seed % 4 == 1:
        options["radius"] = float(random.uniform(20, 60))
    if seed % 4 == 2:
        options["sector"] = (float(random.uniform(0, 360)), float(random.uniform(0, 360)))
        options["min_radius"] = float(random.uniform(0, 9))
    if seed % 8 == 3:
        options["elevation"] = (-70.0, float(random.uniform(-40, -20)))
        options["beam"] = float(random.uniform(60, 150))
    if random.random() < 0.3:
        options["slant_range"] = float(random.uniform(20, 80))
    said = {name: ",".join(map(repr, value)) if isinstance(value, tuple) else repr(value) for name, value in options.items()}
    words = [word for name, value in said.items() for word in (f"--{name.replace('_', '-')}", value)]
    return uav, options, words


@pytest.mark.parametrize("seed", range(200 if LONG else 40))
def test_arrays_are_as_files(seed: int, tmp_path: Path) -> None:
    heights = towns(seed)
    path = ascii_grid(tmp_path / "dsm.asc", heights)
    uav, options, words = asked(seed)
    ground = [["--ground", "-5"], []][seed % 2]
    by_program = program("map", path, *ground, "--uav", ",".join(map(str, uav)), *words)
    scene_options: dict[str, Any] = {"ground": -5.0} if ground else {}
    whole = np.nan_to_num(heights * 4, nan=-9999).astype("i2")
    swapped = heights.astype(heights.dtype.newbyteorder())
    padded = np.full((90, 120), 77.0)
    padded[3:83:2, 5:105:2] = heights
    padded.flags.writeable = False
    turned = np.ascontiguousarray(heights[::-1, ::-1])[::-1, ::-1]
    assert turned.strides[0] < 0 and not swapped.dtype.isnative
    ways: list[tuple[Any, dict[str, Any]]] = [
        (heights, {}),
        (heights.astype("f4"), {}),
        (np.asfortranarray(heights), {}),
        (swapped, {}),
        (heights.astype(">f4"), {}),
        (padded[3:83:2, 5:105:2], {}),
        (turned, {}),
        (np.ma.masked_invalid(heights), {}),
        (np.nan_to_num(heights, nan=-9999), {"nodata": -9999}),
    ]
    for array, said in ways:
        scene = Scene.from_raster(array, transform=PLACE, **said, **scene_options)
        seen = scene.map(uav, **options)
        assert seen.digest == by_program["digest"], array.dtype
        assert seen.document["union"] == by_program["union"]
        assert Scene.open(path, **scene_options).map(uav, **options).digest == seen.digest
    # Of whole numbers every type gives the same.
    kinds = ["i2", ">i2", "i4", ">i4", "i8", "f8", "f4"]
    digests = {
        Scene.from_raster(whole.astype(kind), transform=PLACE, nodata=-9999).map((uav[0], uav[1], 400.0)).digest
        for kind in kinds
    }
    assert len(digests) == 1


def test_unsigned_and_small_numbers() -> None:
    heights = np.zeros((20, 30), dtype="u1")
    heights[5:9, 5:9] = 100
    wanted = Scene.from_raster(heights.astype("f8"), transform=PLACE).map((1030, 4980, 30.0)).digest
    for kind in ["u1", "u2", ">u2", "u4", "u8", "i1", "f2"]:
        assert Scene.from_raster(heights.astype(kind), transform=PLACE).map((1030, 4980, 30.0)).digest == wanted, kind


def test_terrain_below() -> None:
    dsm, dtm = towns(1), np.floor(towns(1) / 8)
    on_grid = Scene.from_raster(dsm, transform=PLACE, terrain=dtm)
    # Coarser cells that hold the same heights where they are looked up.
    flat = np.full((20, 25), -3.0)
    of_flat = Scene.from_raster(dsm, transform=PLACE, terrain=flat, terrain_transform=(4, 0, WEST, 0, -4, NORTH))
    on_flat = Scene.from_raster(dsm, transform=PLACE, ground=-3)
    uav = (1040.0, 4960.0, "60amsl")
    assert on_grid.map(uav).digest != on_flat.map(uav).digest
    assert np.array_equal(of_flat.map(uav).los == 1, on_flat.map(uav).los == 1)


def test_footprints_are_as_files() -> None:
    with open(MUNICH, encoding="utf-8") as file:
        features = json.load(file)["features"]
    uav = (691549.7, 5334762.2, 120)
    by_program = program("map", MUNICH, "--uav", "691549.7,5334762.2,120")
    assert Scene.open(MUNICH).map(uav).digest == by_program["digest"]
    heights = [feature["properties"]["height"] for feature in features]
    ids = [feature.get("id") or feature["properties"].get("id") for feature in features]
    geometries = [feature["geometry"] for feature in features]
    made = Scene.from_footprints(geometries, heights, crs="EPSG:25832", ids=ids)
    assert made.map(uav).digest == by_program["digest"]
    assert Scene.from_footprints((geometries, heights), crs=25832).map(uav).digest == by_program["digest"]
    assert made.link(uav, (691600, 5334700)).obstruction == Scene.open(MUNICH).link(uav, (691600, 5334700)).obstruction


def test_footprints_of_geopandas() -> None:
    geopandas = pytest.importorskip("geopandas")
    table = geopandas.read_file(MUNICH)
    table = table.set_crs("EPSG:25832", allow_override=True)
    uav = (691549.7, 5334762.2, 120)
    wanted = Scene.open(MUNICH).map(uav).digest
    assert Scene.from_footprints(table).map(uav).digest == wanted
    assert Scene.from_footprints(table.geometry, table["height"], crs=table.crs).map(uav).digest == wanted
    # In degrees it is refused, or brought into the zone of UTM.
    degrees = table.to_crs(4326)
    with pytest.raises(skyshed.FileError, match="degrees"):
        Scene.from_footprints(degrees)
    assert Scene.from_footprints(degrees, project="auto").crs == "EPSG:32632"


@pytest.mark.parametrize("name", ["munich", "etoile", "simple_street_canyon"])
def test_cities_of_the_shared_data(name: str) -> None:
    for path in sorted((shared_data() / "cities" / name).glob("*.geojson")):
        words = ["--project", "auto"] if "wgs84" in path.name else []
        scene = Scene.open(path, project="auto" if words else None)
        west, south, east, north = scene.bounds
        uav = ((west + east) / 2 + 0.3, (south + north) / 2 + 0.7, 300)
        by_program = program("map", path, *words, "--uav", ",".join(map(repr, uav)))
        assert scene.map(uav).digest == by_program["digest"]
        assert scene.p_los([uav])[0] == by_program["union"]["p_los"]


def test_other_rasters_of_the_shared_data() -> None:
    """Those that other programs made viewsheds of, and what else can be read."""
    rasterio = pytest.importorskip("rasterio")
    n = 0
    for path in sorted((shared_data() / "viewshed_thirdparty").rglob("*.tif")):
        with rasterio.open(path) as file:
            if file.count != 1 or file.crs is None or file.crs.is_geographic:
                continue
            array, transform, crs, nodata = file.read(1), file.transform, file.crs, file.nodata
        try:
            scene = Scene.from_raster(array, transform=transform, crs=crs, nodata=nodata)
        except skyshed.Error as refused:
            # What is no surface is none in a file, either.
            with pytest.raises(skyshed.Error, match=refused.code):
                Scene.open(path)
            continue
        west, south, east, north = scene.bounds
        uav = ((west + east) / 2, (south + north) / 2, "9000amsl")
        assert scene.map(uav).digest == program("map", path, "--uav", ",".join(map(str, uav)))["digest"], path
        n += 1
    assert n > 3
    folder = shared_data() / "bad" / "good"
    for name in ("dsm.tif", "buildings.geojson"):
        scene = Scene.open(folder / name)
        west, south, east, north = scene.bounds
        uav = ((west + east) / 2, (south + north) / 2, "900amsl")
        assert scene.map(uav).digest == program("map", folder / name, "--uav", ",".join(map(str, uav)))["digest"]


@pytest.mark.parametrize("name", ["cities/munich", "cities/etoile", "cities/simple_street_canyon"])
def test_meshes_of_the_shared_data(name: str) -> None:
    path = shared_data() / name / "mesh.ply"
    scene = Scene.open(path)
    west, south, east, north = scene.bounds
    uav = ((west + east) / 2 + 0.3, (south + north) / 2 + 0.7, "600amsl")
    seen = scene.map(uav)
    assert seen.digest == program("map", path, "--uav", ",".join(map(str, uav)))["digest"]
    assert pickle.loads(pickle.dumps(scene)).map(uav).digest == seen.digest


@pytest.mark.parametrize(
    "name", ["lidar/bilbao", "lidar/delft", "cities/munich", "cities/etoile", "cities/simple_street_canyon"]
)
def test_rasters_of_the_shared_data(name: str) -> None:
    rasterio = pytest.importorskip("rasterio")
    for path in sorted((shared_data() / name).glob("*.tif")):
        with rasterio.open(path) as file:
            heights, transform, crs, nodata = file.read(1), file.transform, file.crs, file.nodata
        scene = Scene.from_raster(heights, transform=transform, crs=crs, nodata=nodata)
        west, south, east, north = scene.bounds
        uav = ((west + east) / 2 + 0.3, (south + north) / 2 + 0.7, 60)
        seen = scene.map(uav)
        assert seen.digest == program("map", path, "--uav", ",".join(map(repr, uav)))["digest"]
        assert Scene.open(path).map(uav).digest == seen.digest


def test_tables_are_those_of_the_program(tmp_path: Path) -> None:
    words = ["place", "itu:urban", "--size", 300, "--height", "60,100", "--step", 50, "--radius", 200]
    by_program = program(*words)
    found = Scene.itu("urban", size=300).place(height=[60, 100], step=50, radius=200)
    for part in ("winner", "refined", "ranked", "digest"):
        assert found[part] == by_program[part], part
    words = ["sample", "itu:urban", "--size", 300, "--zones", "street:20,rooftop:10", "--height", 100, "--radius", 150]
    by_program = program(*words)
    sample = Scene.itu("urban", size=300).sample({"street": 20, "rooftop": 10}, height=100, radius=150)
    parts = [name for name in by_program if name not in ("command", "request", "timing_s")]
    assert len(parts) > 5 and all(sample[name] == by_program[name] for name in parts)
    # Cities in Python always name their seed.
    assert sample["request"] == {**by_program["request"], "seed": 1}
    by_program = program("plos", "itu:urban", "--height", 100, "--theta", "30,60")
    found = skyshed.plos("itu:urban", height=100, theta=[30, 60])
    assert {k: v for k, v in found.document.items() if k not in ("command", "timing_s")} == {
        k: v for k, v in by_program.items() if k not in ("command", "timing_s")
    }
    curve = Scene.itu("urban", size=200).height_curve((100, 100, 80), (10, 100, 10))
    path = tmp_path / "curve.csv"
    program(
        "map", "itu:urban", "--size", 200, "--uav", "100,100,80", "--height-curve", path, "--curve-heights", "10:100:10"
    )
    header, *rows = [line.split(",") for line in path.read_text().splitlines()]
    assert list(curve.table.dtype.names or ()) == header
    assert [float(row[header.index("p_los")]) for row in rows] == curve.table["p_los"].tolist()


def test_heights_that_may_be_off(tmp_path: Path) -> None:
    uav, layers = (100, 100, 60), "los,sure,p-los"
    seen = Scene.itu("urban", size=200, seed=1).map(uav, height_error=2, height_bias=1, sigma=3, layers=layers)
    words = ["--size", "200", "--seed", "1", "--uav", "100,100,60", "--height-error", "2", "--height-bias", "1", "--sigma", "3"]
    words += ["--layers", layers, "-o", str(tmp_path / "layers.tif")]
    site = program("map", "itu:urban", *words)["sites"][0]
    uncertain = site["uncertain"]
    assert seen.p_los_interval == (uncertain["p_los_low"], uncertain["p_los_high"])
    receivers = seen.los < 2
    p_los, sure = seen["p-los"], seen["sure"]
    assert np.isnan(p_los[~receivers]).all() and np.isnan(sure[~receivers]).all()
    assert float(np.mean(p_los[receivers], dtype="f8")) == pytest.approx(uncertain["p_los_mean"], abs=1e-9)
    counts = [int((sure == value).sum()) for value in range(3)]
    assert counts == [uncertain["sure"][name] for name in ("never", "surely", "possibly")]
    # What is sure is as probable as three standard deviations are.
    assert (p_los[sure == 1] > 0.9).all() and (p_los[sure == 0] < 0.1).all()
    assert list(seen.to_xarray()) == ["los", "sure", "p_los"] if skyshed_has_xarray() else True


def test_roofs_as_they_are() -> None:
    delft, uav = MUNICH.parents[1] / "tests" / "lod2" / "delft.city.json", (84550, 447200, 40)
    shaped, flat = (Scene.open(delft, roofs=roofs).map(uav) for roofs in ("lod2", "flat"))
    found = program("map", str(delft), "--roofs", "lod2", "--uav", "84550,447200,40")["sites"][0]
    assert shaped.p_los == found["p_los"]
    assert flat.p_los < shaped.p_los - 0.04
    # A pickled scene keeps its roofs.
    again = pickle.loads(pickle.dumps(Scene.open(delft, roofs="lod2"))).map(uav)
    assert (again.los == shaped.los).all()


def skyshed_has_xarray() -> bool:
    """Whether xarray is installed beside numpy."""
    return importlib.util.find_spec("xarray") is not None


def test_a_uav_over_no_data_has_a_map_and_no_p_los() -> None:
    heights = np.full((40, 40), 100.0)
    heights[15:25, 15:25] = np.nan
    scene = Scene.from_raster(heights, transform=(1, 0, 0, 0, -1, 40))
    places = [(20.0, 20.0, "150amsl"), (5.0, 5.0, "150amsl")]
    over, beside = (scene.map(place) for place in places)
    assert np.isnan(over.p_los) and over.receivers == 1500 and over.reason == "the UAV is over no data"
    assert beside.p_los == 1.0 and beside.reason is None
    assert np.array_equal(scene.p_los(places), [np.nan, 1.0], equal_nan=True)
    both = scene.maps(places)
    assert np.array_equal(both.p_los, [np.nan, 1.0], equal_nan=True) and np.isnan(both.union_p_los)
    # Without data below the answer for each cell is there all the same.
    assert np.array_equal(over.los == 255, np.isnan(heights)) and np.array_equal(over.los == 1, ~np.isnan(heights))
