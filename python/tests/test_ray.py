"""Units of work over Ray: the answers of one process, also where a process dies."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import MUNICH
from test_dask import digests, sites

import skyshed
from skyshed import Scene

ray = pytest.importorskip("ray")
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module", autouse=True)
def cluster() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        paths = f"{Path(skyshed.__file__).parents[1]}:{Path(__file__).parent}"
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": paths}})
    yield
    ray.shutdown()


def test_answers_are_those_of_one_process(tmp_path: Path) -> None:
    from skyshed.ray import map_sites, map_tiles, p_los, place

    munich = Scene.open(MUNICH)
    uavs = sites(24)
    assert np.array_equal(p_los(munich, uavs, radius=300, batch=5), munich.p_los(uavs, radius=300))
    blocks = Scene.from_raster(np.pad(np.full((20, 20), 25.0), 40), transform=(1, 0, 0, 0, -1, 100), ground=0)
    places = [(k, 50, 60) for k in range(0, 100, 5)]
    assert np.array_equal(p_los(blocks, places, batch=3), blocks.p_los(places))
    assert map_sites(munich, uavs, tmp_path / "a" / "{site}.csv", radius=300, batch=7).mapped == 24
    again = map_sites(munich, uavs, tmp_path / "a" / "{site}.csv", radius=300, batch=5)
    assert again == (0, 24)
    asked: dict[str, Any] = {"radius": 300, "layers": "count", "tile_size": 512}
    assert map_tiles(munich, uavs, tmp_path / "b" / "{row}-{col}.tif", batch=2, **asked).mapped == 9
    munich.maps(uavs, radius=300)
    assert len(digests(tmp_path / "b")) == 9
    ranks = place(munich, height=120, step=200, radius=300, batch=3)
    assert [row["rank"] for row in ranks] == [str(k + 1) for k in range(len(ranks))]
    with pytest.raises(skyshed.Error, match="below"):
        map_sites(munich, [*uavs[:3], (691549.7, 5334762.2, -40.0, "below")], tmp_path / "c" / "{site}.csv", radius=300)


def _die_once(asked: Any, part: Any, words: list[str]) -> int:
    flag = Path(words[0]) / str(part)
    if not flag.exists():
        flag.touch()
        os._exit(9)
    return int(part) * 10


def test_a_process_that_dies_is_replaced(tmp_path: Path) -> None:
    from skyshed.ray import _Ray

    assert _Ray().run("dying", _die_once, None, [1, 2, 3], [str(tmp_path)]) == [10, 20, 30]
