"""Errors and warnings, with the codes of docs/codes.md."""

from __future__ import annotations

import warnings as _warnings
from collections.abc import Iterable

Told = tuple[str, str]


class Error(ValueError):
    """What was asked cannot be answered: what is wrong, a stable ``code`` and, where one is known, a ``hint``."""

    def __init__(self, text: str, code: str, hint: str | None = None) -> None:
        super().__init__(f"{code}: {text}" + (f" (hint: {hint})" if hint else ""))
        self.text = text
        self.code = code
        self.hint = hint

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.text, self.code, self.hint)


class FileError(Error, OSError):
    """A file that cannot be read, used or written."""

    def __str__(self) -> str:
        return ValueError.__str__(self)


class SkyshedWarning(UserWarning):
    """Something odd that stopped nothing: what was found, what was done instead, and a stable ``code``."""

    def __init__(self, text: str, code: str) -> None:
        super().__init__(f"{code}: {text}")
        self.text = text
        self.code = code

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.text, self.code)


def tell(told: Iterable[Told], known: Iterable[Told] = (), stacklevel: int = 3) -> None:
    """Warns of what was told and is not known yet."""
    known = set(known)
    for code, text in told:
        if (code, text) not in known:
            _warnings.warn(SkyshedWarning(text, code), stacklevel=stacklevel)


def wrong(argument: str, found: str, wanted: str, code: str = "E113") -> Error:
    """The error of an argument."""
    return Error(f"{argument}: found {found}, wanted {wanted}", code)
