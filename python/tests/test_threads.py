"""Scenes are shared by threads, survive a fork and a pickle, leave nothing behind, and hear Ctrl-C."""

from __future__ import annotations

import gc
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from conftest import LONG, MUNICH

from skyshed import Scene

pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")

PLACES = [(691549.7 + 13 * k, 5334762.2 - 7 * k, 120.0) for k in range(40)]


def test_a_scene_knows_where_its_file_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, top in [("one", 20), ("two", 40)]:
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        Scene.from_raster(np.pad(np.full((20, 20), top), 40), transform=(1, 0, 0, 0, -1, 100), ground=0).save("dsm.tif")
    monkeypatch.chdir(tmp_path / "one")
    scene = Scene.open("dsm.tif", ground=0)
    wanted = scene.sample({"street": 20}, height=30, radius=30).table["p_los"]
    monkeypatch.chdir(tmp_path / "two")
    again = pickle.loads(pickle.dumps(scene))
    assert again.map((20, 50, 30)).digest == scene.map((20, 50, 30)).digest
    assert np.array_equal(scene.sample({"street": 20}, height=30, radius=30).table["p_los"], wanted, equal_nan=True)


def test_names_are_no_words(tmp_path: Path) -> None:
    for name in ["-x", "--help", "itu:urban", "a b,c"]:
        scene = Scene.from_raster(np.zeros((9, 9)), transform=(1, 0, 0, 0, -1, 9), ground=0, name=name)
        assert scene.link((4, 4, 5), (1, 1)).los


def test_masks_are_lent_to_many_at_once() -> None:
    seen = blocks().map((30, 40, 60.0))
    with ThreadPoolExecutor(4) as threads:
        for _ in range(20):
            made = threads.submit(Scene.from_raster, seen.los, transform=(1, 0, 0, 0, -1, 200))
            assert all(threads.map(lambda _: seen.los[0, 0] in (0, 1), range(20)))
            made.result()


def blocks() -> Scene:
    heights = np.zeros((200, 300))
    heights[50:90, 60:100] = 30
    return Scene.from_raster(heights, transform=(1, 0, 0, 0, -1, 200), ground=0)


def digests_of(scene: Scene) -> list[str]:
    return [scene.map((x, y, 60.0)).digest for x, y in [(30, 40), (200, 150), (150, 20)]]


def test_eight_threads_over_one_scene() -> None:
    scene = Scene.open(MUNICH)
    wanted = [scene.map(uav).digest for uav in PLACES]
    with ThreadPoolExecutor(8) as threads:
        found = list(threads.map(lambda uav: scene.map(uav).digest, PLACES * 4))
    assert found == wanted * 4


def test_pickles_are_equal() -> None:
    city = Scene.itu("urban", size=200, seed=3)
    footprints = Scene.from_footprints([{"type": "Polygon", "coordinates": [[[0, 0], [30, 0], [30, 20], [0, 0]]]}], [9])
    terrain = np.add.outer(np.arange(200) / 40, np.arange(300) / 60)
    surface = Scene.from_raster(terrain + 5, transform=(1, 0, 500, 0, -1, 900), terrain=terrain, crs=25832)
    for scene in [Scene.open(MUNICH), city, footprints, surface, blocks()]:
        again = pickle.loads(pickle.dumps(scene))
        west, south, east, north = scene.bounds
        uav = ((west + east) / 2, (south + north) / 2, "300amsl")
        assert again.map(uav).digest == scene.map(uav).digest
        assert (again.crs, again.transform, again.shape) == (scene.crs, scene.transform, scene.shape)
        rx = (west + 1, south + 1, "100amsl")
        assert again.link(uav, rx).margin == scene.link(uav, rx).margin


@pytest.mark.parametrize("way", ["fork", "spawn"])
def test_other_processes(way: str, tmp_path: Path) -> None:
    # In a process of its own: this one has threads of other tests, which no child may be forked beside.
    script = tmp_path / "pool.py"
    script.write_text(
        "import multiprocessing, sys\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from test_threads import blocks, digests_of\n"
        "if __name__ == '__main__':\n"
        "    scene = blocks()\n"
        "    wanted = digests_of(scene)\n"
        f"    with multiprocessing.get_context({way!r}).Pool(2) as pool:\n"
        "        assert pool.map(digests_of, [scene] * 4) == [wanted] * 4\n"
    )
    subprocess.run([sys.executable, str(script)], check=True, timeout=60)


def cpu_seconds(process: int) -> float:
    """Processor time of a process so far, on which it does not matter how busy the machine is; 0 of one that is gone."""
    stat = Path(f"/proc/{process}/stat")
    if not stat.exists():
        return 0.0
    fields = stat.read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident() -> int:
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is read from /proc")
def test_nothing_leaks() -> None:
    scene = blocks()
    array = np.random.default_rng(1).random((200, 300))

    def work(n: int) -> None:
        for k in range(n):
            seen = scene.map((30 + k % 200, 40.0, 60.0))
            assert seen.los[0, 0] in (0, 1) and seen.document
            if k % 20 == 0:
                Scene.from_raster(array, transform=(1, 0, 0, 0, -1, 200)).p_los([(50, 50, 60)])

    work(300)
    gc.collect()
    before = resident()
    work(10_000 if LONG else 1500)
    gc.collect()
    # A mask has 59 KiB: one in a hundred that was lost would show.
    assert resident() - before < 8000


def test_an_array_outlives_its_map() -> None:
    scene = blocks()
    wanted = scene.map((30, 40, 60.0)).los.copy()
    lent = scene.map((30, 40, 60.0)).los
    gc.collect()
    for k in range(50):
        scene.map((40 + k, 40, 60.0))
    assert np.array_equal(lent, wanted) and not lent.flags.writeable
    with pytest.raises(ValueError):
        lent[0, 0] = 1


@pytest.mark.parametrize(
    "work",
    [
        "scene.maps([(k, 40 + k / 100, 300) for k in range(4000)])",
        "scene.p_los([(k % 4000, 40 + k / 100, 300) for k in range(100000)])",
        "scene.place(height=300, step=3)",
        "Scene.itu('urban', size=20000)",
        "Scene.from_raster(np.zeros((20000, 20000), 'f4'), transform=(1, 0, 0, 0, -1, 20000))",
        "skyshed.plos('itu:urban', method='city', cities=100000)",
        "scene.sample({'street': 2000}, height=100)",
        "scene.map((2000, 2000, 300), zones=True)",
        "Scene.itu('urban', size=12000).height_curve((6000, 6000, 300))",
    ],
)
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processor time is read from /proc")
def test_ctrl_c_is_heard_at_once(work: str) -> None:
    lines = [
        "import signal, sys, time, warnings, numpy as np, skyshed",
        # Who was started in the background ignores it otherwise.
        "signal.signal(signal.SIGINT, signal.default_int_handler)",
        "from skyshed import Scene",
        "warnings.simplefilter('ignore')",
        "scene = Scene.itu('urban', size=4000)",
        "print('ready', flush=True)",
        "try:",
        f"    {work}",
        "except KeyboardInterrupt:",
        "    print('stopped', flush=True)",
        "else:",
        "    print('done', flush=True)",
    ]
    process = subprocess.Popen([sys.executable, "-c", "\n".join(lines)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    start = cpu_seconds(process.pid)
    answer = process.stdout.readline()
    spent = cpu_seconds(process.pid) - start
    process.kill()
    process.wait()
    if answer == "done\n":
        pytest.skip("this machine is done sooner")
    assert answer == "stopped\n"
    # Of as many threads as there are cores.
    assert spent < 0.2 * max(2, os.cpu_count() or 2), f"{spent:.2f} s"


def test_progress_is_told() -> None:
    shares: list[float] = []
    scene = Scene.itu("urban", size=1500)
    scene.p_los([(k % 1500, 40 + k / 100, 300) for k in range(4000)], progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0 and min(shares) >= 0

    def fails(share: float) -> None:
        raise RuntimeError("seen")

    if shares:
        with pytest.raises(RuntimeError, match="seen"):
            scene.p_los([(k % 1500, 40 + k / 100, 300) for k in range(4000)], progress=fails)
    tqdm = pytest.importorskip("tqdm")
    with tqdm.tqdm(total=100, disable=True) as bar:
        scene.maps(PLACES[:0] or [(10, 10, 300)], progress=bar)
