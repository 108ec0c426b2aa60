"""Tiles over a cluster, candidates over a cluster, and what goes wrong there."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import LONG, MUNICH
from test_dask import digests, killed_workers

import skyshed
from skyshed import Scene

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")

#: Meters, and cells, along a side of the scene; those of a tile; UAVs; the radius.
SIDE, TILE, N_UAVS, RADIUS = (20000, 1008, 800, 700) if LONG else (1000, 208, 25, 150)


def uavs() -> list[tuple[float, float, str, str]]:
    random = np.random.default_rng(7)
    places = np.round(random.uniform(0, SIDE, (N_UAVS, 2)), 2)
    # Some on borders of tiles.
    places[::5, 0] = SIDE - TILE * np.round((SIDE - places[::5, 0]) / TILE)
    return [(float(x), float(y), "200amsl", f"s{k}") for k, (x, y) in enumerate(places)]


def run(*words: object) -> None:
    subprocess.run([sys.executable, "-m", "skyshed", *map(str, words), "-q"], check=True)


@pytest.fixture(scope="module")
def dsm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("scene") / "dsm.tif"
    run("city", "itu:urban", "--size", SIDE, "--seed", 3, "-o", file)
    table = "\n".join(f"{x!r},{y!r},{h},{id}" for x, y, h, id in uavs())
    (file.parent / "sites.csv").write_text(f"x,y,h,id\n{table}\n")
    return file


@pytest.fixture(scope="module")
def line(dsm: Path) -> list[object]:
    """What is asked of the program."""
    sites = ["--uavs", dsm.parent / "sites.csv", "--radius", RADIUS]
    return ["map", dsm, "--ground=0", *sites, "--layers", "count,union", "--tile-size", TILE]


@pytest.fixture(scope="module")
def serial(line: list[object], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The tiles of one run of the program."""
    folder = tmp_path_factory.mktemp("serial-tiles")
    run(*line, "-o", folder / "{row}-{col}.tif")
    return digests(folder)


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
    with distributed.Client(cluster) as client:
        yield client
    cluster.close()


ASKED: dict[str, Any] = {"ground": 0, "radius": RADIUS, "layers": ["count", "union"], "tile_size": TILE}


def test_killed_workers_lose_no_tile(client: Any, dsm: Path, serial: dict[str, str], tmp_path: Path) -> None:
    from skyshed.dask import map_tiles

    out = tmp_path / "{row}-{col}.tif"
    with killed_workers(client) as killed:
        map_tiles(dsm, uavs(), out, client=client, batch=1, **ASKED)
    assert killed
    assert digests(tmp_path) == serial
    # Again in other batches all is there; as well by a scene that was opened.
    again = map_tiles(dsm, uavs(), out, client=client, batch=7, **ASKED)
    assert again == (0, len(serial)) and digests(tmp_path) == serial
    if not LONG:
        opened = Scene.open(dsm, ground=0)
        asked = {name: value for name, value in ASKED.items() if name != "ground"}
        assert map_tiles(opened, uavs(), out, client=client, **asked) == (0, len(serial))


def test_a_killed_driver_of_tiles_starts_again(line: list[object], dsm: Path, serial: dict[str, str], tmp_path: Path) -> None:
    script, out = tmp_path / "driver.py", tmp_path / "out"
    script.write_text(
        "import sys, warnings\n"
        "warnings.simplefilter('ignore')\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from distributed import Client\n"
        "from skyshed.dask import map_tiles\n"
        "from test_tiles import ASKED, uavs\n"
        "if __name__ == '__main__':\n"
        "    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:\n"
        f"        map_tiles({str(dsm)!r}, uavs(), {str(out / '{row}-{col}.tif')!r}, client=client, batch=int(sys.argv[1]), **ASKED)\n"
    )
    driver = subprocess.Popen([sys.executable, str(script), "1"], stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 120
    while time.monotonic() < deadline and not (out.is_dir() and len(list(out.glob("*.tif"))) > 3):
        time.sleep(0.02)
    os.killpg(driver.pid, signal.SIGKILL)
    driver.wait()
    assert 0 < len(list(out.glob("*.tif"))) < len(serial)
    subprocess.run([sys.executable, str(script), "5"], check=True)
    assert digests(out) == serial
    # Nothing is lost or doubled in what is merged.
    merged = [sys.executable, "-m", "skyshed", "jobs", "merge", "-q", "-o", tmp_path / "merged.csv", "-o", tmp_path / "merged.parquet"]
    subprocess.run([*map(str, merged), *map(str, line), "-o", str(out / "{row}-{col}.tif")], check=True)
    rows = (tmp_path / "merged.csv").read_text().splitlines()[1:]
    assert [row.split(",")[0] for row in rows] == [uav[3] for uav in uavs()]
    frame = pytest.importorskip("pyarrow.parquet").read_table(tmp_path / "merged.parquet").to_pydict()
    header = (tmp_path / "merged.csv").read_text().splitlines()[0].split(",")
    los = header.index("los")
    assert frame["los"] == [int(row.split(",")[los]) for row in rows] and frame["site"] == [uav[3] for uav in uavs()]


RECIPES = Path(__file__).parents[2] / "examples" / "cluster"


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """An environment in which the program is called ``skyshed``."""
    program = tmp_path / "bin" / "skyshed"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m skyshed "$@"\n')
    program.chmod(0o755)
    return {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"}


@pytest.mark.skipif(shutil.which("parallel") is None, reason="GNU parallel is not at hand")
def test_the_recipe_of_parallel_loses_no_tile(
    line: list[object], serial: dict[str, str], environment: dict[str, str], tmp_path: Path
) -> None:
    # Programs that are killed are run again.
    out = tmp_path / "out"
    out.mkdir()
    words = ["sh", str(RECIPES / "parallel.sh"), "12", *map(str, line), "-o", str(out / "{row}-{col}.tif")]
    running = subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, text=True, cwd=tmp_path)
    killed = 0
    while running.poll() is None and killed < (20 if LONG else 3):
        time.sleep(1 if LONG else 0.15)
        found = subprocess.run(["pgrep", "-f", f"{out}.*--shard [0-9]+/12"], capture_output=True, text=True, check=False)
        for process in found.stdout.split()[:1]:
            try:
                os.kill(int(process), signal.SIGKILL)
                killed += 1
            except ProcessLookupError:
                pass
    answer, _ = running.communicate()
    assert running.returncode == 0 and f"{len(serial)} done, 0 missing, 0 broken" in answer, answer
    assert killed and digests(out) == serial


def test_the_recipe_of_slurm_makes_all_tiles(
    line: list[object], serial: dict[str, str], environment: dict[str, str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    for k in (3, 1, 2, 2):
        # As `sbatch --array=1-3` runs it, one task queued twice.
        of_task = {**environment, "SLURM_ARRAY_TASK_ID": str(k), "SLURM_CPUS_PER_TASK": "1"}
        words = ["bash", str(RECIPES / "slurm.sh"), "3", *map(str, line), "-o", str(out / "{row}-{col}.tif")]
        subprocess.run(words, env=of_task, check=True)
    assert digests(out) == serial


@pytest.mark.skipif(shutil.which("snakemake") is None, reason="Snakemake is not at hand")
def test_the_recipe_of_snakemake_makes_all_sites(
    environment: dict[str, str], dsm: Path, tmp_path: Path
) -> None:
    (tmp_path / "sites.csv").write_text("id,x,y,h\n" + "".join(f"s{k},{50 * k},{60 * k},200amsl\n" for k in range(1, 8)))
    asked = f"{dsm} --ground 0 --uavs sites.csv --radius 100 -o {{site}}.tif"
    words = ["snakemake", "--snakefile", str(RECIPES / "Snakefile"), "--cores", "2", "--config", "shards=3", f"map={asked}"]
    subprocess.run(words, env=environment, check=True, cwd=tmp_path, capture_output=True)
    rows = (tmp_path / "merged.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows[1:]] == [f"s{k}" for k in range(1, 8)]


@pytest.mark.skipif(shutil.which("nextflow") is None, reason="Nextflow is not at hand")
def test_the_recipe_of_nextflow_makes_all_sites(environment: dict[str, str], dsm: Path, tmp_path: Path) -> None:
    sites, out = tmp_path / "sites.csv", tmp_path / "out"
    out.mkdir()
    sites.write_text("id,x,y,h\n" + "".join(f"s{k},{50 * k},{60 * k},200amsl\n" for k in range(1, 8)))
    asked = f"{dsm} --ground 0 --uavs {sites} --radius 100 -o '{out}/{{site}}.tif'"
    words = ["nextflow", "run", str(RECIPES / "main.nf"), "--shards", "3", "--map", asked]
    subprocess.run(words, env=environment, check=True, cwd=tmp_path, capture_output=True)
    assert len((tmp_path / "merged.csv").read_text().splitlines()) == 8


def test_tiles_are_an_array_of_chunks(client: Any, dsm: Path) -> None:
    from skyshed.dask import tiles

    pytest.importorskip("xarray")
    small = (dsm, uavs()[:9])
    count = tiles(*small, ground=0, radius=RADIUS, tile_size=TILE)
    n_tiles = -(-SIDE // TILE)
    assert count.data.numblocks == (n_tiles, n_tiles) and count.shape == (SIDE, SIDE)
    window = count[: 2 * TILE, : 2 * TILE]
    whole = Scene.open(dsm, ground=0).maps(small[1], radius=RADIUS) if not LONG else None
    if whole is not None:
        wanted = whole.to_xarray()["count"].reindex(y=count.y, x=count.x, method="nearest", tolerance=0.1)
        found = window.compute()
        cells = wanted[: 2 * TILE, : 2 * TILE]
        assert (found == cells.fillna(0)).all() and int((found > 0).sum()) > 0
        wanted = whole.to_xarray()["count"]
        assert count.attrs == wanted.attrs and count.spatial_ref.attrs == wanted.spatial_ref.attrs


def test_candidates_are_ranked_as_in_one_run(client: Any) -> None:
    from skyshed.dask import place

    munich = Scene.open(MUNICH)
    asked: dict[str, Any] = {"step": 40 if LONG else 120, "radius": 300, "over": "street"}
    found = place(munich, height="60,120", client=client, batch=5, **asked)
    serial = munich.place(height="60,120", **asked)
    header, *rows = serial._found.table
    wanted = [dict(zip(header, row)) for row in rows]
    wanted = [row for row in wanted if row["kind"] == "candidate"]
    assert len(wanted) >= 20 and found == wanted
    with pytest.raises(skyshed.Error, match="count"):
        place(munich, height=60, client=client, count=3)
    with pytest.raises(skyshed.Error, match="margin"):
        place(munich, height=60, client=client, goal="margin")


def test_workers_keep_to_their_memory(tmp_path: Path, dsm: Path) -> None:
    from skyshed.dask import map_tiles

    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, memory_limit="256MB", dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        # A tile of all takes more than that, and says so instead of being killed.
        large = tmp_path / "large.tif"
        run("city", "itu:suburban", "--size", 6000, "-o", large)
        with pytest.raises(skyshed.Error, match="tile 0,0") as raised:
            map_tiles(large, [(3000, 3000, 100, "a")], tmp_path / "{row}-{col}.tif", tile_size=6016, ground=0, client=client, layers="count")
        assert raised.value.code == "E501"
        done = map_tiles(large, [(3000, 3000, 100, "a")], tmp_path / "{row}-{col}.tif", tile_size=1024, ground=0, radius=500, client=client, layers="count")
        assert done.mapped == 36


def test_inputs_that_change_or_break_are_named(client: Any, tmp_path: Path) -> None:
    from skyshed.dask import map_tiles

    file, out = tmp_path / "dsm.tif", tmp_path / "out"
    asked: dict[str, Any] = {"ground": 0, "radius": 60, "layers": "count", "tile_size": 64, "client": client, "batch": 1}
    run("city", "itu:urban", "--size", 200, "--seed", 3, "-o", file)
    places = [(float(k), 100.0, "200amsl", f"s{k}") for k in range(10, 200, 30)]
    assert map_tiles(file, places, out / "{row}-{col}.tif", **asked).mapped == 16
    before = digests(out)
    # Changed between tries: what is there is of another run, and is left alone.
    run("city", "itu:urban", "--size", 200, "--seed", 4, "--overwrite", "-o", file)
    with pytest.raises(skyshed.Error, match="16 of 16 tiles failed.*made by another run") as raised:
        map_tiles(file, places, out / "{row}-{col}.tif", **asked)
    assert raised.value.code == "E106" and digests(out) == before
    # A file whose blocks are damaged: the tiles over them are named, the rest is done.
    data = bytearray(file.read_bytes())
    damaged, fresh = tmp_path / "damaged.tif", tmp_path / "fresh"
    import rasterio

    with rasterio.open(file) as source:
        profile = {**source.profile, "driver": "GTiff", "tiled": True, "blockxsize": 64, "blockysize": 64, "compress": "deflate"}
        with rasterio.open(damaged, "w", **profile) as target:
            target.write(source.read())
    data = bytearray(damaged.read_bytes())
    with rasterio.open(damaged) as source:
        offset = int(source.get_tag_item("BLOCK_OFFSET_3_3", "TIFF", bidx=1))
    data[offset : offset + 20] = b"\xff" * 20
    damaged.write_bytes(bytes(data))
    with pytest.raises(skyshed.Error, match="tile 3,3") as raised:
        map_tiles(damaged, places, fresh / "{row}-{col}.tif", **asked)
    names = {path.name for path in fresh.iterdir()}
    assert "1-1.tif" in names and "3-3.tif" not in names and not any(name.startswith(".") for name in names)
    with pytest.raises(skyshed.Error, match="E301|no such file"):
        map_tiles(tmp_path / "none.tif", places, fresh / "{row}-{col}.tif", **asked)


def test_a_folder_that_cannot_be_written_loses_nothing(client: Any, tmp_path: Path) -> None:
    from skyshed.dask import map_tiles

    file, full = tmp_path / "dsm.tif", Path("/dev/full")
    run("city", "itu:urban", "--size", 100, "--seed", 3, "-o", file)
    asked: dict[str, Any] = {"ground": 0, "radius": 60, "layers": "count", "tile_size": 64, "client": client}
    out = tmp_path / "out"
    out.mkdir()
    (out / "0-0.tif").mkdir()
    with pytest.raises(skyshed.Error, match="1 of 4 tiles failed, the others are done: .*tile 0,0"):
        map_tiles(file, [(50, 50, "200amsl", "a")], out / "{row}-{col}.tif", **asked)
    assert {path.name for path in out.iterdir()} == {"0-0.tif", "0-1.tif", "1-0.tif", "1-1.tif"}
    with pytest.raises(skyshed.Error):
        map_tiles(file, [(50, 50, "200amsl", "a")], full / "{row}-{col}.tif", **asked)
