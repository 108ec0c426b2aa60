"""Many sites over the workers of a Dask cluster: files of each, or P_LoS of all.

A unit of work is one site. Its files depend on the scene, the site and the options alone, appear when they are complete, and are left
alone where they are. So workers may die, sites may be handed out twice, and a driver that was killed goes on where it was::

    client = Client(processes=True)
    map_sites(scene, sites, "out/{site}.tif", client=client)
"""

from __future__ import annotations

import csv
import json
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from distributed import Client, as_completed, get_client, get_worker
from distributed.scheduler import KilledWorker

from skyshed._answers import shares
from skyshed._errors import Error, wrong
from skyshed._scene import Origin, Scene, opened_once
from skyshed._words import AskedUav, PathLike, files_of, uavs_of, words_of

if TYPE_CHECKING:
    import numpy.typing as npt

#: A task takes about so long [s]: much to a scheduler, little to do again.
TASK_S = 2.0
#: Most sites of a task.
MOST_A_TASK = 500
#: How often workers may die over one task.
DEATHS = 10

_Part = TypeVar("_Part")


class Mapped(NamedTuple):
    """What became of the sites of a run."""

    #: Sites whose files were made.
    mapped: int
    #: Sites whose files were there.
    there: int


def map_sites(
    scene: Scene,
    sites: Iterable[Any],
    out: PathLike | Sequence[PathLike],
    *,
    client: Client | None = None,
    batch: int | None = None,
    **options: object,
) -> Mapped:
    """Maps each site into files of its own, over the workers of a cluster; ``{site}`` in ``out`` is its name.

    Sites are as for :meth:`Scene.maps`, options those of ``skyshed map``. Files that are there, made by an equal run, are left alone.
    ``batch`` sites go to a worker at a time, by default as many as take two seconds.

    Raises an :class:`Error` that names the sites that failed, once all others are done.
    """
    listed: list[AskedUav] = [(x, y, h, id if id is not None else str(k + 1)) for k, (x, y, h, id) in enumerate(_sites(scene, sites))]
    name, n = Counter(site[3] for site in listed).most_common(1)[0]
    if n > 1:
        raise wrong("sites", f"{n} of the name {name!r}", "a name of its own for each", "E207")
    outputs = [os.path.abspath(file) for file in ([out] if isinstance(out, (str, os.PathLike)) else out)]
    if not all("{site}" in file for file in outputs):
        raise wrong("out", repr(out), "names with {site}, such as out/{site}.tif", "E105")
    for folder in {os.path.dirname(file) for file in outputs if "{site}" not in os.path.dirname(file)}:
        os.makedirs(folder, exist_ok=True)
    words = [*words_of({**options, "resume": True}), *files_of(outputs)]
    done = _over_workers(scene, listed, _map_some, words, client, batch)
    counts = [part for part, _ in done]
    failed = [failure for _, failures in done for failure in failures]
    if failed:
        told = "; ".join(f"{id}: {why}" for id, why in failed[:5])
        more = f"; and {len(failed) - 5} more" if len(failed) > 5 else ""
        text = f"{len(failed)} of {len(listed)} sites failed, the others are done: {told}{more}"
        # The code of the first, as the program has it.
        raise Error(text, failed[0][1].code)
    return Mapped(sum(part.mapped for part in counts), sum(part.there for part in counts))


def p_los(
    scene: Scene,
    uavs: Iterable[Any],
    *,
    client: Client | None = None,
    batch: int | None = None,
    **sight: object,
) -> npt.NDArray[np.float64]:
    """P_LoS of each of some UAVs, as :meth:`Scene.p_los`, over the workers of a cluster."""
    listed = _sites(scene, uavs)
    parts = _over_workers(scene, listed, _count_some, words_of(sight), client, batch)
    return shares(np.concatenate(parts))


def _sites(scene: Scene, sites: Iterable[Any]) -> list[AskedUav]:
    listed = uavs_of(sites, scene.crs)
    if not listed:
        raise wrong("sites", "none", "at least one", "E108")
    return listed


def _over_workers(
    scene: Scene,
    sites: list[AskedUav],
    work: Callable[[Any, list[AskedUav], list[str]], _Part],
    words: list[str],
    client: Client | None,
    batch: int | None,
) -> list[_Part]:
    """What workers make of parts of the sites, in their order. A part whose workers die is handed out again."""
    client = client or get_client()
    n = batch or _sites_of_task(scene, sites, words)
    parts = [sites[first : first + n] for first in range(0, len(sites), n)]
    # Of a file its name goes around; of arrays the scene itself, to each worker once.
    spread: Any = client.scatter
    asked: Any = scene._origin or spread(scene, broadcast=True, hash=False)
    futures = {client.submit(work, asked, part, words, pure=False, retries=2): k for k, part in enumerate(parts)}
    deaths = dict.fromkeys(range(len(parts)), 0)
    found: dict[int, _Part] = {}
    as_done: Any = as_completed
    running = as_done(futures)
    for future in running:
        k = futures.pop(future)
        try:
            found[k] = future.result()
        except KilledWorker:
            deaths[k] += 1
            if deaths[k] > DEATHS:
                names = ", ".join(str(site[3] or site[:3]) for site in parts[k][:5])
                raise Error(f"workers die over the sites {names} …: is there memory enough?", "E501") from None
            again = client.submit(work, asked, parts[k], words, pure=False, retries=2)
            futures[again] = k
            running.add(again)
    return [found[k] for k in range(len(parts))]


def _sites_of_task(scene: Scene, sites: list[AskedUav], words: list[str]) -> int:
    """Sites that take about two seconds, by what counting one takes here; files take as long again."""
    start = time.perf_counter()
    try:
        scene._scene.counts(sites[:1], [word for word in words if word.startswith(("--radius", "--rx", "--receivers"))])
    except Error:
        return 1
    spent = 2 * (time.perf_counter() - start) + 1e-3
    return int(min(max(TASK_S / spent, 1), MOST_A_TASK, max(len(sites) // 8, 1)))


def _of_worker(asked: Scene | Origin) -> Scene:
    """The scene of a task, which each worker opens once. A worker's threads are as many as its cluster gives it."""
    try:
        os.environ.setdefault("RAYON_NUM_THREADS", str(get_worker().state.nthreads))
    except ValueError:
        pass
    return opened_once(asked) if isinstance(asked, Origin) else asked


def _count_some(asked: Scene | Origin, sites: list[AskedUav], words: list[str]) -> npt.NDArray[np.uint64]:
    return _of_worker(asked)._scene.counts(sites, words)


def _map_some(asked: Scene | Origin, sites: list[AskedUav], words: list[str]) -> tuple[Mapped, list[tuple[str, Error]]]:
    """Files of some sites; those that fail are told one by one."""
    scene = _of_worker(asked)
    try:
        return _map_all(scene, sites, words), []
    except Error:
        done = Mapped(0, 0)
        failed: list[tuple[str, Error]] = []
        for site in sites:
            try:
                own = _map_all(scene, [site], words)
                done = Mapped(done.mapped + own.mapped, done.there + own.there)
            except Error as error:
                failed.append((str(site[3]), error))
        return done, failed


def _map_all(scene: Scene, sites: list[AskedUav], words: list[str]) -> Mapped:
    with tempfile.TemporaryDirectory(prefix="skyshed-") as folder:
        path = os.path.join(folder, "sites.csv")
        with open(path, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([("x", "y", "h", "id"), *((repr(x), repr(y), h, id) for x, y, h, id in sites)])
        word, of_scene = (scene._origin.word, scene._origin.words) if scene._origin else ("memory", [])
        line = ["map", word, *of_scene, f"--uavs={path}", *words]
        counts = json.loads(scene._scene.ask(line).document)
    return Mapped(counts["mapped"], counts["there"])
