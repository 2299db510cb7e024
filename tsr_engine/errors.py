"""Every error that the engine raises on purpose.

    TsrError
    ├── UsageError        2   a wrong option, parameter name or value
    ├── InputError        3   a file that is missing, empty, damaged, or not what it claims
    │   └── VideoError    3   a video that cannot be opened or decoded
    ├── ModelError        4   a model that is missing, of another version, or with a wrong hash
    ├── EvidenceError     5   an evidence folder that is damaged or belongs to something else
    └── StorageError      6   a full disk or an unwritable folder

The number is the exit code of the command line. A message is one sentence: what was expected,
what was got and where, then what to do. 1 is left to unexpected failures, 130 to Ctrl-C.
"""

from __future__ import annotations

from typing import Literal

ImportProblem = Literal["broken", "too_large", "unsafe"]
"""What is wrong with a file of another tool: it breaks a rule of its format; there is or unfolds more of it than is
read; or it asks for what no annotations need and attacks do (names that lead out of an archive, a DOCTYPE)."""

StorageProblem = Literal["full", "limit", "failed"]
"""Why something cannot be written: no room is left, a file would be larger than it may be, or anything else."""


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
        kind: what is in the way; the same to a person, but not to a server that is asked.
    """

    exit_code = 6

    def __init__(self, message: str, kind: StorageProblem = "failed") -> None:
        super().__init__(message)
        self.kind: StorageProblem = kind


class ExportError(TsrError):
    """What was asked for cannot be written in this format."""

    exit_code = 7


class ImportFormatError(InputError):
    """A file of another tool that breaks a rule; says file, line and rule.

    Attributes:
        kind: of rule; the same to a person, but not to a server that is asked.
    """

    def __init__(self, message: str, kind: ImportProblem = "broken") -> None:
        super().__init__(message)
        self.kind: ImportProblem = kind
