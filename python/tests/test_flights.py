"""Walks and flights: places in memory are those of a file, one UAV or several."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import skyshed
from skyshed import LivePage, Scene

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


def test_layers_of_all_uavs_are_those_of_their_masks() -> None:
    city = Scene.itu("urban", size=200)
    random = np.random.default_rng(5)
    for range_m in (None, 60.0):
        begin = np.datetime64("2026-05-01T12:00")
        ends = [(None, None)] + [tuple(np.sort(random.choice(120, 2, replace=False))) for _ in range(40)]
        uavs = []
        for from_min, to_min in ends:
            x, y = random.uniform(5, 195, 2)
            uav = {"x": float(x), "y": float(y), "h": float(random.uniform(90, 120))}
            if from_min is not None:
                uav |= {"from": begin + np.timedelta64(int(from_min), "m"), "to": begin + np.timedelta64(int(to_min), "m")}
            uavs.append(uav)
        # Nobody is up all the time but the first, who is left out every other time.
        uavs, ends = (uavs, ends) if range_m else (uavs[1:], ends[1:])
        maps = city.maps(uavs, radius=range_m, layers=["uptime", "gap", "all"], keep=True)
        masks = np.array([city.map(uav, radius=range_m).los for uav in uavs])
        if range_m is None:
            assert np.array_equal(maps.layer("all") == 1, (masks == 1).all(axis=0))
        first, last = min(e[0] for e in ends if e[0] is not None), max(e[1] for e in ends if e[1] is not None)
        minutes = np.arange(first, last)
        is_up = np.array([[f is None or f <= m < t for m in minutes] for f, t in ends])
        seen = np.einsum("um,urc->mrc", is_up.astype(int), (masks == 1).astype(int)) > 0
        receives = (masks <= 1).any(axis=0)
        uptime, gap = maps.layer("uptime"), maps.layer("gap")
        assert np.array_equal(np.isnan(uptime), ~receives) and np.array_equal(np.isnan(gap), ~receives)
        np.testing.assert_allclose(uptime[receives], seen.mean(axis=0)[receives], atol=1e-6)
        longest, run = np.zeros(receives.shape), np.zeros(receives.shape)
        for of_minute in seen:
            run = np.where(of_minute, 0, run + 1)
            longest = np.maximum(longest, run)
        np.testing.assert_allclose(gap[receives], longest[receives], atol=1e-4)
        assert 0 < np.nanmean(uptime) < 1
    with pytest.raises(skyshed.Error, match="asked for"):
        maps.layer("best-server")
    frame = pytest.importorskip("pandas").DataFrame({"x": [50.0, 90], "y": [60.0, 20], "h": [80.0, 90], "from": [0, 5], "to": [5, None]})
    assert np.nanmax(city.maps(frame, layers=["gap"]).layer("gap")) <= 5


def test_links_in_arrays_are_single_links() -> None:
    city = Scene.itu("urban", size=200)
    random = np.random.default_rng(9)
    uavs = [(float(x), float(y), float(h)) for x, y, h in random.uniform((5, 5, 80), (195, 195, 120), (6, 3))]
    places = random.uniform(5, 195, (40, 2))
    table = city.links(uavs, places)
    assert table.los.shape == (6, 40) and len(table) == 240
    n_faults = 0
    for k, rx in enumerate(places):
        if k in table.rx_faults:
            n_faults += 1
            assert (table.los[:, k] == 255).all() and np.isnan(table["margin_m"][:, k]).all()
            with pytest.raises(skyshed.Error, match="building"):
                city.link(uavs[0], tuple(rx))
            continue
        for u, uav in enumerate(uavs):
            link = city.link(uav, tuple(rx))
            margin = np.nan if link.margin is None else link.margin
            assert table.los[u, k] == link.los
            assert np.array_equal(table["margin_m"][u, k], margin, equal_nan=True)
            assert table["distance_m"][u, k] == link.distance and table["elevation_deg"][u, k] == link.elevation
            # A link that is asked in words is the same.
            if u == 0:
                words = city.link(uav, tuple(rx), rx_height=1.5)
                assert (words.los, words.margin, words.obstruction) == (link.los, link.margin, link.obstruction)
                assert words.document["obstruction"] == link.document["obstruction"] == link.obstruction
    assert 0 < n_faults < 40
    pairs = city.links(uavs, places[:6], pairs=True)
    assert np.array_equal(pairs.los, table.los[np.arange(6), np.arange(6)])
    only = city.links(uavs, places, los_only=True)
    assert np.array_equal(only.los, table.los) and only.keys() == ["los", "uavs", "receivers"]
    far = city.links(uavs, places, radius=50)
    assert (far.los[table["distance_m"] > 50] == 255).all()
    with pytest.raises(skyshed.Error, match="pairs"):
        city.links(uavs, places, pairs=True)
    with pytest.raises(skyshed.Error, match="receivers"):
        city.links(uavs, [(1, 2, 3, 4)])


def test_bad_uavs_of_a_batch_are_nan_with_a_reason() -> None:
    city = Scene.itu("urban", size=200)
    random = np.random.default_rng(3)
    uavs = [(float(x), float(y), 3.0) for x, y in random.uniform(5, 195, (20, 2))]
    with pytest.raises(skyshed.Error, match="of 20 UAVs"):
        city.maps(uavs)
    maps = city.maps(uavs, bad_uavs="skip", keep=True)
    bad = [k for k in range(20) if str(k + 1) in maps.reasons]
    assert 1 < len(bad) < 19 and all("building" in reason for reason in maps.reasons.values())
    assert (np.isnan(maps.p_los) == [k in bad for k in range(20)]).all() and (maps.receivers[bad] == 0).all()
    good = [k for k in range(20) if k not in bad]
    alone = [city.map(uavs[k]) for k in good]
    assert maps.p_los[good].tolist() == [coverage.p_los for coverage in alone]
    assert [coverage.digest for coverage in maps] == [coverage.digest for coverage in alone]
    for k, coverage in zip(good, alone):
        assert np.array_equal(maps.which >> np.uint64(k) & np.uint64(1), coverage.los == 1)
    assert not (maps.which & np.uint64(sum(1 << k for k in bad))).any()
    lifted = city.maps(uavs, bad_uavs="lift")
    assert not lifted.reasons and not np.isnan(lifted.p_los).any()
    with pytest.raises(skyshed.Error):
        city.maps([uavs[bad[0]]], bad_uavs="skip")
    with pytest.raises(skyshed.Error, match="bad_uavs"):
        city.maps(uavs, bad_uavs="drop")  # type: ignore[arg-type]


def test_a_page_shows_the_flight_of_a_file_or_of_an_array(tmp_path: Path) -> None:
    city = Scene.itu("urban", size=200)
    file = tmp_path / "flight.csv"
    file.write_text("x,y,h\n" + "".join(f"{x},{y},{h}\n" for x, y, h in FLIGHT))

    def tracks(page: LivePage) -> object:
        facts = json.loads(page.html.split('id="facts">')[1].split("</script>")[0])
        return facts["tracks"]

    wanted = [{"name": None, "vertices": [[x, y, h, None] for x, y, h in FLIGHT]}]
    assert tracks(city.live(track=file)) == tracks(city.live(track=np.array(FLIGHT))) == wanted
    assert tracks(city.live()) == []
    with pytest.raises(skyshed.Error, match="E103"):
        city.live(track=[1.0, 2.0])
