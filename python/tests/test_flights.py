"""Walks and flights: places in memory are those of a file, one UAV or several."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import skyshed
from skyshed import Scene

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

FLIGHT = [(20.0, 20.0, 40.0), (180.0, 30.0, 40.0), (150.0, 170.0, 60.0)]


def test_a_flight_in_memory_is_that_of_a_file(tmp_path: Path) -> None:
    city = Scene.itu("urban", size=200)
    pilot = (100.0, 100.0, 1.5)
    file = tmp_path / "flight.csv"
    file.write_text("x,y,h\n" + "".join(f"{x},{y},{h}\n" for x, y, h in FLIGHT))
    wanted = city.track(pilot, file)
    assert wanted["exact_stretches"] and wanted["rx_height_m"] is None
    for flight in (FLIGHT, np.array(FLIGHT)):
        assert city.track(pilot, flight)["stretches"] == wanted["stretches"]
    # Lengths of legs in space.
    legs = [np.linalg.norm(np.subtract(b, a)) for a, b in zip(FLIGHT, FLIGHT[1:])]
    assert wanted["length_m"]["total"] == pytest.approx(sum(legs))


def test_several_pilots_see_what_one_of_them_sees() -> None:
    city = Scene.itu("urban", size=200)
    pilots = [(100.0, 100.0, 1.5), (30.0, 150.0, 1.5)]
    both = city.track(pilots, FLIGHT)
    each = [city.track(pilot, FLIGHT) for pilot in pilots]
    assert [of["stretches"] for of in both["observers"]] != []
    for of_both, alone in zip(both["observers"], each):
        assert of_both["length_m"] == alone["length_m"]
    assert both["length_m"]["los"] >= max(alone["length_m"]["los"] for alone in each)


def test_a_line_of_shapely_is_above_the_datum(tmp_path: Path) -> None:
    shapely = pytest.importorskip("shapely")
    city = Scene.itu("urban", size=200)
    line = shapely.LineString(FLIGHT)
    assert city.track((100, 100, 1.5), line)["length_m"] == city.track((100, 100, 1.5), FLIGHT)["length_m"]
    with pytest.raises(skyshed.Error, match="shape"):
        city.track((100, 100, 1.5), np.zeros((3, 4)))
