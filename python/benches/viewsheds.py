"""skyshed beside xarray-spatial on one array: time, memory, and cells that differ from line of sight by its definition.

    python python/benches/viewsheds.py [cells a side …]

Each runs in a process of its own, so that memory is its own. Observers stand at the center of a cell, for xarray-spatial moves them
there. What is right is decided by `method="ray"`, one exact link for each cell.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np

HEIGHT, TARGET = 20.0, 1.5


def surface(n: int) -> Any:
    """Rolling ground with blocks on it."""
    import xarray

    random = np.random.default_rng(7)
    axis = np.arange(n)
    heights = np.add.outer(8 * np.sin(axis / 60), 6 * np.cos(axis / 45)) + random.random((n, n)) * 0.2
    for _ in range(n * n // 900):
        row, col = random.integers(n, size=2)
        heights[row : row + random.integers(5, 20), col : col + random.integers(5, 20)] += random.uniform(3, 25)
    coords = {"y": n - 0.5 - axis, "x": axis + 0.5}
    return xarray.DataArray(heights.astype("f4"), dims=("y", "x"), coords=coords, name="dsm")


def status(name: str) -> int:
    """A line of the status of this process [bytes]."""
    with open("/proc/self/status", encoding="ascii") as file:
        return 1024 * next(int(line.split()[1]) for line in file if line.startswith(name))


def measure(who: str, n: int, path: str) -> None:
    """Prints seconds to be ready and for a map, bytes a cell beside the array, and writes the cells that are seen."""
    array = surface(n)
    at = n // 2 + 0.5

    def run(array: Any, at: float) -> Any:
        if who == "xarray-spatial":
            from xrspatial import viewshed

            return viewshed(array, x=at, y=at, observer_elev=HEIGHT, target_elev=TARGET).values >= 0
        import skyshed.xarray  # noqa: F401

        options = {"method": "ray"} if who == "ray" else {}
        scene = array.skyshed.scene()
        return scene.map((at, at, HEIGHT), rx_height=TARGET, **options).los == 1

    start = time.perf_counter()
    run(surface(60), 30.5)
    compiled = time.perf_counter() - start
    # The peak from here on.
    with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")
    before = status("VmRSS")
    start = time.perf_counter()
    seen = run(array, at)
    spent = time.perf_counter() - start
    memory = (status("VmHWM") - before) / n / n
    np.save(path, seen)
    print(json.dumps({"who": who, "cells": n, "start_s": compiled, "map_s": spent, "bytes_per_cell": memory}))


if __name__ == "__main__":
    if len(sys.argv) > 2 and sys.argv[1] == "--one":
        import warnings

        warnings.simplefilter("ignore")
        measure(sys.argv[2], int(sys.argv[3]), sys.argv[4])
        sys.exit()
    with tempfile.TemporaryDirectory() as folder:
        for n in map(int, sys.argv[1:] or ["1000", "2000"]):
            by_rays = None
            for who in ("ray", "skyshed", "xarray-spatial"):
                path = f"{folder}/{who}.npy"
                line = [sys.executable, __file__, "--one", who, str(n), path]
                found = json.loads(subprocess.run(line, capture_output=True, text=True, check=True).stdout)
                seen = np.load(path)
                by_rays = seen if by_rays is None else by_rays
                print({**found, "wrong": int(np.sum(seen != by_rays))}, flush=True)
