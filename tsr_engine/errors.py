"""Every error that the engine raises on purpose.

    TsrError
    ├── UsageError        2   a wrong option, parameter name or value
    ├── InputError        3   a file that is missing, empty, damaged, or not what it claims
    │   └── VideoError    3   a video that cannot be opened or decoded
    ├── ModelError        4   a model that is missing, of another version, or with a wrong hash
    ├── EvidenceError     5   an evidence folder that is damaged or belongs to something else
    ├── StorageError      6   a full disk or an unwritable folder
    └── ExportError       7   content that a format cannot hold

The number is the exit code of the command line; 1 means an unexpected failure, 130 Ctrl-C. A message is one sentence:
it says what was expected, what was got and where, and what to do.
"""

from __future__ import annotations

from typing import Literal

ImportProblem = Literal["broken", "too_large", "unsafe"]
"""Problem of a file of another tool: it breaks a rule of its format; it is larger than the limit, packed or unpacked;
or it contains what attacks use and annotations do not need (names that lead out of an archive, a DOCTYPE)."""

StorageProblem = Literal["full", "limit", "failed"]
"""Why a file cannot be written: the disk is full, the file would exceed its limit, or another reason."""


class TsrError(Exception):
    """Base of all errors that are explained to the user in one sentence."""

    exit_code = 1


class UsageError(TsrError):
    """A wrong option, parameter name or value."""

    exit_code = 2


class InputError(TsrError):
    """A file or folder that is missing, empty, damaged, or not what it claims to be."""

    exit_code = 3


class VideoError(InputError):
    """A video that cannot be opened or decoded."""


class ModelError(TsrError):
    """A model that is missing, of another version, or whose hash does not match its manifest."""

    exit_code = 4


class EvidenceError(TsrError):
    """An evidence folder that is damaged, of another version, or belongs to another video."""

    exit_code = 5


class StorageError(TsrError):
    """A full disk or a folder that cannot be written.

    Attributes:
        kind: the reason; the server chooses its HTTP status by it.
    """

    exit_code = 6

    def __init__(self, message: str, kind: StorageProblem = "failed") -> None:
        super().__init__(message)
        self.kind: StorageProblem = kind


class ExportError(TsrError):
    """Content that cannot be written in the chosen format."""

    exit_code = 7


class ImportFormatError(InputError):
    """A file of another tool that breaks a rule; the message names file, line and rule.

    Attributes:
        kind: kind of the broken rule; the server chooses its HTTP status by it.
    """

    def __init__(self, message: str, kind: ImportProblem = "broken") -> None:
        super().__init__(message)
        self.kind: ImportProblem = kind
