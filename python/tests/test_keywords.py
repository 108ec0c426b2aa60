"""No keyword of any question is taken in silence: with it the answer differs, or an error names it."""

from __future__ import annotations

import inspect
import json
import os
import re
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skyshed
from skyshed import Scene, _skyshed, keywords
from skyshed._options import as_json

#: A value of each keyword, other than its default.
VALUES: dict[str, Any] = {
    # Scenes.
    "terrain": "terrain.asc",
    "ground": np.float64(5.0),
    "building_threshold": 4,
    "height_field": "tall",
    "top_field": "z_top",
    "height_unit": "ft",
    "levels_field": "tall",
    "base_field": "tall",
    "parts": "join",
    "height_error_field": "tall",
    "roofs": "lod2",
    "layer": "a",
    "missing": ("levels", 9),
    "base": "highest",
    "data_area": Path("part.geojson"),
    "extent": (0, 0, 48, 48),
    "cell": 0.5,
    "crs": "EPSG:25832",
    # These meters are no degrees.
    "project": "no system",
    "size": 210,
    "seed": np.int64(5),
    "nodata_as": "block",
    "band": 2,
    "hash": True,
    # Receivers, range, antennas, earth.
    "rx_height": "30ft",
    "receivers": "all",
    "radius": np.float32(25),
    "method": "xdraw",
    "min_radius": 15,
    "sector": np.array([20, 110]),
    "elevation": (-80, -50),
    "beam": 50,
    "slant_range": 60,
    "earth_k": 1e-4,
    "curvature_coefficient": 9999,
    # Maps and their files.
    "height_error": 3,
    "height_bias": 2,
    "sigma": 1,
    "layers": ["los", "margin"],
    "tolerance": 0.2,
    "zones": True,
    "bare": True,
    "tif_layout": "plain",
    "gdal_values": True,
    "polygons": "los",
    "simplify": 2,
    "title": "007",
    "attribution": "Somebody",
    "width": 900,
    "dpi": 150,
    "overwrite": True,
    "csv_text": True,
    # Questions.
    "every": 3,
    "swap_axes": True,
    "stretches": "stretches.csv",
    "follow_ground": True,
    "bad_uavs": "skip",
    "uav_error": 2,
    "cities": 3,
    "block": 30,
    "step": 15,
    "over": "street",
    "skip_bad": True,
    "shard": "1/2",
    "clearance": 45,
    "goal": "margin",
    "weights": "terrain.asc",
    "minimize": "height",
    "count": 2,
    "map": "best.png",
    "top": 1,
    "centers": True,
    "ci": 0.8,
    "tile": 20,
    "curve": "mine=mine.csv",
    "theta": [30, 60],
    "distance": 60,
    "phi": 10,
    "alpha": 0.4,
    "beta": 400,
    "gamma": 12,
    "users": "street",
    "placement": "street",
    "uav_clear_of_roof": True,
    "until": 0.2,
    "users_per_city": 3,
    "links": 300,
    "positions": 20,
    "theta_band": 2,
    "plot": "heat",
}

#: Keywords that by their nature change no answer here, and the test that shows what they do.
QUIET = {
    "overwrite": "an existing file is replaced with it alone",
    "csv_text": "no name of these scenes means something to a spreadsheet",
    "hash": "small inputs are hashed anyway",
    "parts": "this file has none: building_meaning",
    "skip_bad": "no row of these tables is bad",
    "bad_uavs": "no UAV of these is bad",
    "swap_axes": "the extent of this city is the same with its axes exchanged",
    "method": "exact engines agree",
}


def building(x: float, y: float, **properties: object) -> dict[str, Any]:
    ring = [[x, y], [x + 8, y], [x + 8, y + 8], [x, y + 8], [x, y]]
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keywords")
    city = [building(8 + 16 * k, 8 + 16 * j, height=9 + 4 * k, tall=3 + j, z_top=30 + k) for k in range(3) for j in range(3)]
    city.append(building(50, 50, tall=4))
    collection = {"type": "FeatureCollection", "features": city}
    (folder / "city.geojson").write_text(json.dumps(collection))
    (folder / "part.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [building(20, 20)]}))
    head = "ncols 64\nnrows 64\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
    slope = "\n".join(" ".join(str(1 + (row + col) // 16) for col in range(64)) for row in range(64))
    (folder / "terrain.asc").write_text(head + slope)
    (folder / "mine.csv").write_text("theta_deg,p_los\n30,0.5\n60,0.8\n")
    return folder


UAV = (4.0, 4.0, 50.0)
UAVS = [(4.0, 4.0, 50.0), (45.0, 45.0, 30.0)]


def document(answer: Any) -> str:
    """An answer without what differs between any two runs."""

    def forget(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {k: forget(v) for k, v in value.items() if k not in ("command", "request", "timing", "memory")}
        return [forget(part) for part in value] if isinstance(value, list) else value

    return json.dumps(forget(answer.document))


def city(**reading: Any) -> Scene:
    return Scene.open("city.geojson", **{"missing": "drop", "data_area": "all", **reading})


def of_picture(ask: Callable[..., Any]) -> Callable[..., str]:
    """The answer, and the picture beside it."""

    def asked(**options: Any) -> str:
        Path("out.svg").unlink(missing_ok=True)
        answer = ask(output="out.svg", **options)
        picture = re.sub("<metadata>.*?</metadata>", "", Path("out.svg").read_text(), flags=re.DOTALL)
        # A map of the winner is another file.
        return document(answer) + picture + str(sorted(os.listdir()))

    return asked


def saved(**options: Any) -> str:
    coverage = city().map(UAV)
    for file in Path().glob("saved.*"):
        file.unlink()
    coverage.save("saved.png", "saved.tif", "saved.geojson", **options)
    return "".join(str(Path(name).read_bytes()) for name in ("saved.png", "saved.tif", "saved.geojson"))


#: A question of each class of keywords.
QUESTIONS: dict[str, Callable[..., Any]] = {
    "SceneKeywords": lambda **o: document(city(**o).map(UAV)) + str(city(**o).crs),
    "SightKeywords": lambda **o: str(city().p_los(UAVS, **o)) + city().map(UAV, **o).digest,
    "MapKeywords": lambda **o: document(city().map(UAV, **o)),
    "SaveKeywords": saved,
    "LinkKeywords": of_picture(lambda **o: city().link(UAV, (41, 40), **o)),
    "TrackKeywords": of_picture(lambda **o: city().track(UAV, [(2, 2), (60, 58)], **o)),
    "LimitsKeywords": lambda **o: document(city().limits([UAV], **o)),
    "CompareKeywords": of_picture(lambda **o: city().compare(UAVS, **o)),
    "ZonesKeywords": of_picture(lambda **o: city().zones(**o)),
    "PlaceKeywords": of_picture(lambda **o: city().place(height=(40, 60), **o)),
    "SampleKeywords": of_picture(lambda **o: Scene.itu("urban", size=200).sample({"street": 4}, height=60, **o)),
    "InfoKeywords": lambda **o: document(skyshed.info("city.geojson", **{"missing": "drop", **o})),
    "PlosKeywords": of_picture(lambda **o: skyshed.plos("itu:urban", height=100, **o)),
}
#: These only save what another question has.
ELSEWHERE = {"AnySceneKeywords", "FootprintKeywords", "CityKeywords"}


def classes() -> dict[str, type]:
    found = inspect.getmembers(keywords, inspect.isclass)
    return {name: kind for name, kind in found if kind.__module__ == keywords.__name__}


def test_every_question_is_asked_here() -> None:
    assert set(classes()) == set(QUESTIONS) | ELSEWHERE


@pytest.mark.parametrize("name", sorted(QUESTIONS))
def test_no_keyword_is_taken_in_silence(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    warnings.simplefilter("ignore")
    ask = QUESTIONS[name]
    base = ask()
    silent = []
    for keyword in sorted(classes()[name].__optional_keys__):  # type: ignore[attr-defined]
        value = VALUES[keyword]
        try:
            if ask(**{keyword: value}) == base and keyword not in QUIET:
                silent.append(keyword)
        except (skyshed.Error, TypeError, OSError) as error:
            words = (keyword, keyword.replace("_", " "), keyword.split("_")[0].rstrip("s"), str(value))
            assert any(word in str(error) for word in words), f"{keyword}: {error}"
    assert not silent


@pytest.mark.parametrize("name", sorted(QUESTIONS))
def test_an_unknown_keyword_is_refused(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    warnings.simplefilter("ignore")
    with pytest.raises((skyshed.Error, TypeError), match="radiuss"):
        QUESTIONS[name](radiuss=5)


#: A command, and options without which it has no request.
REQUESTS: dict[str, tuple[str, dict[str, object]]] = {
    "MapKeywords": ("map", {"scene": "itu:urban"}),
    "LinkKeywords": ("link", {"scene": "itu:urban", "uav": ["1,2,30"], "rx": ["5,6"]}),
    "TrackKeywords": ("track", {"scene": "itu:urban", "uav": ["1,2,30"], "track": "walk.csv"}),
    "LimitsKeywords": ("limits", {"scene": "itu:urban"}),
    "CompareKeywords": ("compare", {"scene": "itu:urban"}),
    "ZonesKeywords": ("zones", {"scene": "itu:urban"}),
    "CityKeywords": ("city", {"scene": "itu:urban"}),
    "PlaceKeywords": ("place", {"scene": "itu:urban", "height": (60, "30roof")}),
    "SampleKeywords": ("sample", {"scene": "itu:urban", "zones": ["street:3"], "height": 60}),
    "InfoKeywords": ("info", {"scene": "city.geojson"}),
    "PlosKeywords": ("plos", {"scenes": ["itu:urban"], "height": [60, 100.5]}),
}


def spellings(value: object) -> list[object]:
    """A value as users of Python write it."""
    if isinstance(value, (bool, np.bool_)):
        return [True, np.True_]
    if isinstance(value, (int, float, np.number)):
        number = float(value)
        whole = [int(number), np.int32(number), np.uint8(number)] if number == int(number) and 0 <= number < 256 else []
        floats = [] if whole else [number, np.float64(number), np.asarray(number)]
        return [*floats, *whole]
    if isinstance(value, (str, os.PathLike)):
        text = os.fspath(value)
        return [text, Path(text)] if "." in text and "=" not in text else [text]
    parts = list(value)  # type: ignore[call-overload]
    of_numbers = [np.array(parts)] if all(isinstance(part, (int, float)) for part in parts) else []
    return [tuple(parts), parts, *of_numbers]


@pytest.mark.parametrize("name", sorted(REQUESTS))
def test_all_spellings_of_keywords_are_one_request(name: str) -> None:
    command, base = REQUESTS[name]
    keywords = sorted(classes()[name].__optional_keys__)  # type: ignore[attr-defined]
    numbers = np.random.default_rng(7)
    n_read = 0
    for _ in range(10_000 if "SKYSHED_LONG" in os.environ else 100):
        some = numbers.choice(keywords, size=numbers.integers(0, 5), replace=False)
        found = set()
        for _ in range(2):
            chosen = {str(keyword): spellings(VALUES[keyword]) for keyword in some}
            asked = {keyword: of[numbers.integers(len(of))] for keyword, of in chosen.items()}
            try:
                found.add(_skyshed.normalized(command, as_json({**base, **asked, "radiuss": None})))
                n_read += 1
            except skyshed.Error as error:
                found.add(str(error))
        assert len(found) == 1, (some, found)
    assert n_read > 50
