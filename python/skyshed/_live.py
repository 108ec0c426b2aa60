"""The live page of a scene, as a file and in a notebook."""

from __future__ import annotations

import html
import os
from typing import NamedTuple


class LivePage(NamedTuple):
    """One HTML page in which UAVs are dragged over a scene and the exact coverage follows. A notebook shows it at once."""

    html: str

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.html)

    def _repr_html_(self) -> str:
        page = html.escape(self.html, quote=True)
        return f'<iframe srcdoc="{page}" width="100%" height="700" style="border:0"></iframe>'

    def __repr__(self) -> str:
        return f"LivePage({len(self.html)} bytes)"
