"""What tests share: the program, scenes of all kinds, the shared data where it is at hand."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
MUNICH = REPOSITORY / "maps" / "munich.geojson"
LONG = "SKYSHED_LONG" in os.environ


def shared_data() -> Path:
    """The folder of the shared data; the test is skipped without it."""
    folder = Path(os.environ.get("SKYSHED_TRUTH", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("the shared data are not at hand")
    return folder


def program(*words: object, folder: Path | None = None) -> Any:
    """The document that the program prints on the command line."""
    line = [sys.executable, "-m", "skyshed", *map(str, words), "--json", "-q"]
    done = subprocess.run(line, capture_output=True, text=True, cwd=folder, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def towns(seed: int, n_rows: int = 40, n_cols: int = 50) -> np.ndarray[Any, Any]:
    """Heights of whole quarters of a meter with blocks, slopes and holes."""
    random = np.random.default_rng(seed)
    heights = np.round(np.add.outer(np.sin(np.arange(n_rows) / 9) * 3, np.arange(n_cols) / 20) * 4) / 4
    for _ in range(12):
        row, col = random.integers(n_rows), random.integers(n_cols)
        heights[row : row + random.integers(2, 9), col : col + random.integers(2, 9)] += random.integers(2, 120) / 4
    if seed % 3 == 0:
        heights[random.integers(n_rows), random.integers(n_cols)] = np.nan
    return heights


@pytest.fixture(autouse=True)
def _from_the_root(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(REPOSITORY)
