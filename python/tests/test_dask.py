"""Sites over a cluster: nothing is lost or doubled when workers and drivers are killed, and bytes are those of one serial run."""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import LONG, MUNICH

import skyshed
from skyshed import Scene

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")

N_SITES = 2000 if LONG else 120


def sites(n: int) -> list[tuple[float, float, float, str]]:
    random = np.random.default_rng(5)
    xs, ys = random.uniform(691150, 692050, n), random.uniform(5334450, 5335050, n)
    return [(round(float(x), 2), round(float(y), 2), 120.0, f"s{k}") for k, (x, y) in enumerate(zip(xs, ys))]


def digests(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def client() -> Any:
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with distributed.Client(cluster) as client:
        yield client
    cluster.close()


@contextmanager
def killed_workers(client: Any) -> Iterator[list[int]]:
    """Kills a worker again and again, but none that is starting: its nanny would give up, and the cluster shrink."""
    stop, killed = threading.Event(), list[int]()

    def kill() -> None:
        random = np.random.default_rng(1)
        while not stop.wait(3 if LONG else 0.04):
            running = [w for w in client.cluster.workers.values() if getattr(getattr(w.process, "status", None), "name", "") == "running"]
            known = client.scheduler_info(n_workers=-1)["workers"]
            processes = [worker.pid for worker in running if worker.worker_address in known and worker.pid]
            if processes and (LONG or len(killed) < 3):
                victim = int(random.choice(processes))
                try:
                    os.kill(victim, signal.SIGKILL)
                    killed.append(victim)
                except ProcessLookupError:
                    pass

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        yield killed
    finally:
        stop.set()
        killer.join()


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The files of one run of the program."""
    folder = tmp_path_factory.mktemp("serial")
    rows = "\n".join(f"{x!r},{y!r},{h!r},{id}" for x, y, h, id in sites(N_SITES))
    (folder.parent / "sites.csv").write_text(f"x,y,h,id\n{rows}\n")
    line = [sys.executable, "-m", "skyshed", "map", str(MUNICH), "--uavs", str(folder.parent / "sites.csv"), "--radius=300.0", "-q"]
    subprocess.run([*line, "-o", str(folder / "{site}.tif"), "-o", str(folder / "{site}.csv")], check=True)
    return digests(folder)


def test_p_los_is_that_of_one_process(client: Any) -> None:
    from skyshed.dask import p_los

    munich = Scene.open(MUNICH)
    uavs = sites(60)
    wanted = munich.p_los(uavs, radius=300)
    assert np.array_equal(p_los(munich, uavs, client=client, radius=300), wanted)
    assert np.array_equal(p_los(munich, uavs, client=client, batch=7, radius=300), wanted)
    blocks = Scene.from_raster(np.pad(np.full((20, 20), 25.0), 40), transform=(1, 0, 0, 0, -1, 100), ground=0)
    places = [(k, 50, 60) for k in range(0, 100, 5)]
    assert np.array_equal(p_los(blocks, places, client=client, batch=3), blocks.p_los(places))


def test_killed_workers_lose_nothing(client: Any, serial: dict[str, str], tmp_path: Path) -> None:
    from skyshed.dask import map_sites

    munich = Scene.open(MUNICH)
    outputs = [tmp_path / "{site}.tif", tmp_path / "{site}.csv"]
    with killed_workers(client) as killed:
        map_sites(munich, sites(N_SITES), outputs, client=client, batch=5, radius=300.0)
    assert killed
    assert digests(tmp_path) == serial
    # Again, in other batches: all is there.
    again = map_sites(munich, sites(N_SITES), outputs, client=client, batch=17, radius=300.0)
    assert again == (0, N_SITES) and digests(tmp_path) == serial


def test_a_killed_driver_starts_again(serial: dict[str, str], tmp_path: Path) -> None:
    script = tmp_path / "driver.py"
    out = tmp_path / "out"
    script.write_text(
        "import sys, warnings\n"
        "warnings.simplefilter('ignore')\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from distributed import Client\n"
        "from skyshed import Scene\n"
        "from skyshed.dask import map_sites\n"
        "from test_dask import MUNICH, N_SITES, sites\n"
        "if __name__ == '__main__':\n"
        "    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:\n"
        f"        outputs = [{str(out / '{site}.tif')!r}, {str(out / '{site}.csv')!r}]\n"
        "        print(map_sites(Scene.open(MUNICH), sites(N_SITES), outputs, client=client, batch=int(sys.argv[1]), radius=300.0))\n"
    )
    driver = subprocess.Popen([sys.executable, str(script), "4"], stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (out.is_dir() and len(list(out.iterdir())) > 20):
        time.sleep(0.05)
    os.killpg(driver.pid, signal.SIGKILL)
    driver.wait()
    n_before = len(list(out.glob("s*.tif")))
    done = subprocess.run([sys.executable, str(script), "11"], capture_output=True, text=True, check=True)
    assert digests(out) == serial, done.stdout
    assert 0 < n_before


def test_sites_that_fail_are_named_and_the_others_done(client: Any, tmp_path: Path) -> None:
    from skyshed.dask import map_sites

    munich = Scene.open(MUNICH)
    bad = [*sites(10), (691549.7, 5334762.2, -40.0, "below"), (691550.0, 5334762.2, "nowhere", "odd")]
    with pytest.raises(skyshed.Error, match="below") as raised:
        map_sites(munich, bad[:-1], tmp_path / "{site}.csv", client=client, batch=4, radius=300.0)
    assert "1 of 11 sites failed" in str(raised.value)
    assert {path.name for path in tmp_path.glob("*.csv")} == {f"s{k}.csv" for k in range(10)}
    with pytest.raises(skyshed.Error, match="out"):
        map_sites(munich, sites(3), tmp_path / "all.tif", client=client)


def test_shards_are_the_same_units(serial: dict[str, str], tmp_path: Path) -> None:
    rows = "\n".join(f"{x!r},{y!r},{h!r},{id}" for x, y, h, id in sites(N_SITES))
    (tmp_path / "other.csv").write_text(f"x,y,h,id\n{rows}\n")
    out = tmp_path / "out"
    out.mkdir()
    for k in (3, 1, 2):
        words = ["--uavs", tmp_path / "other.csv", "--shard", f"{k}/3", "--radius=300.0"]
        line = [sys.executable, "-m", "skyshed", "map", MUNICH, *words, "-q", "-o", out / "{site}.tif", "-o", out / "{site}.csv"]
        subprocess.run([*map(str, line), "--resume"], check=True)
    assert digests(out) == serial


def test_scenes_in_memory_are_told_apart(client: Any, tmp_path: Path) -> None:
    from skyshed.dask import map_sites

    def blocks(top: float) -> Scene:
        return Scene.from_raster(np.pad(np.full((20, 20), top), 40), transform=(1, 0, 0, 0, -1, 100), ground=0)

    asked: dict[str, Any] = {"client": client, "batch": 1}
    places, out = [(5, 50, 80, "a"), (90, 50, 80, "b")], tmp_path / "{site}.csv"
    assert map_sites(blocks(25), places, out, **asked).mapped == 2
    assert map_sites(blocks(25), places, out, **asked) == (0, 2)
    with pytest.raises(skyshed.Error, match="made by another run"):
        map_sites(blocks(60), places, out, **asked)
