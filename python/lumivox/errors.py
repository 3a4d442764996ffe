"""Errors of files that are also those of the system: ``except FileNotFoundError`` meets them."""

from __future__ import annotations

import errno

from lumivox._native import ScanError


class FileError(ScanError, OSError):
    """A file that cannot be read: :class:`ScanError` and ``OSError``."""

    def __init__(self, message: str = "", filename: str | None = None, number: int | None = None) -> None:
        super().__init__(message)
        self.filename, self.errno = filename, number

    def __str__(self) -> str:
        # The system's class would make words of the number and the name.
        return str(self.args[0]) if self.args else ""

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (str(self), self.filename, self.errno)


class MissingFileError(FileError, FileNotFoundError):
    """A file or folder that is not there: :class:`ScanError` and ``FileNotFoundError``."""

    def __init__(self, message: str = "", filename: str | None = None, number: int | None = errno.ENOENT) -> None:
        super().__init__(message, filename, number)
