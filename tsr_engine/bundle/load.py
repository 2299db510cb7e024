"""Opens a bundle from another person, and checks everything in it before use."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

from tsr_engine.bundle.clip import ClipFrame
from tsr_engine.bundle.expectation import Expectation, read_expectation
from tsr_engine.bundle.layout import CORRECTIONS, EVIDENCE, EXPECTATION, FRAMES, MANIFEST, NETWORK, OUTPUT, README
from tsr_engine.bundle.manifest import Manifest
from tsr_engine.bundle.output import Output, numbered_lines, read_rows
from tsr_engine.errors import ImportFormatError, TsrError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.evidence.schema import DATABASE
from tsr_engine.evidence.untrusted import check_untrusted
from tsr_engine.exchange.archive import ArchiveLimits, unpack
from tsr_engine.exchange.untrusted_zip import is_archive
from tsr_engine.io.digest import file_sha256
from tsr_engine.io.video_probe import check_file

LIMITS = ArchiveLimits(
    entries=200,
    total=8 << 30,
    single=4 << 30,
    directory=1 << 20,
    advice="So it is not a bug bundle; if it is an export, 'tsr import' reads it.",
)
"""Limits of an unpacked bundle."""
_REQUIRED_FILES = (
    README,
    FRAMES,
    OUTPUT,
    EXPECTATION,
    CORRECTIONS,
    f"{EVIDENCE}/run.json",
    f"{EVIDENCE}/evidence.sqlite",
)
_MAX_TEXT_BYTES = 64 << 20
"""Largest text file that is read into memory, bytes."""


@dataclass(frozen=True, slots=True)
class Bundle:
    """An unpacked bundle whose files match its manifest; ``output`` is that of the run."""

    name: str
    folder: Path
    manifest: Manifest
    frames: tuple[ClipFrame, ...]
    expectation: Expectation
    output: Output

    @property
    def clip(self) -> Path:
        """The clip."""
        return self.folder / self.manifest.clip.file


def is_bundle(path: Path) -> bool:
    """Whether a path is treated as a bundle: it is a file, or has a bundle's suffix."""
    return path.is_file() or path.suffix.lower() == ".zip"


@contextmanager
def open_bundle(path: Path) -> Iterator[Bundle]:
    """Unpack and check a bundle; it is removed when the block ends.

    Raises:
        ImportFormatError: not a bundle, hostile, damaged, or of another format; names the file and the reason.
    """
    if not path.is_file():
        raise ImportFormatError(f"There is no bundle at {path}. Check the path.")
    if path.suffix.lower() != ".zip" and not is_archive(path):
        raise ImportFormatError(f"{path} is not a bundle (.zip). Name one, or the evidence folder of a run.")
    with TemporaryDirectory(prefix="tsr-bundle-") as name:
        try:
            yield read_bundle(path, Path(name))
        except TsrError as error:
            # The folder is temporary, so messages must not name it.
            raise type(error)(str(error).replace(f"{name}{os.sep}", f"{path.name}: ")) from None


def read_bundle(path: Path, folder: Path) -> Bundle:
    """Unpack a bundle into an empty folder, and check it.

    Raises:
        ImportFormatError: see ``open_bundle``.
    """
    names = unpack(path, folder, limits=LIMITS)
    manifest = Manifest.read(folder, path.name)
    _check_files(path.name, folder, manifest, names)
    check_file(folder / manifest.clip.file)
    frames = _read_frames(folder / FRAMES, manifest)
    expectation = read_expectation(folder / EXPECTATION)
    span = expectation.span()
    if span is not None and not (manifest.frames.first <= span[0] and span[1] < manifest.frames.stop):
        raise ImportFormatError(f"{EXPECTATION} is about frames that are not in the bundle. Create it again.")
    output = Output.from_rows(read_rows(folder / OUTPUT), manifest.frames.first, manifest.frames.stop)
    return Bundle(path.name, folder, manifest, frames, expectation, output)


def open_evidence(bundle: Bundle) -> EvidenceReader:
    """Open the evidence of a bundle, after a check that it is safe to read.

    Raises:
        EvidenceError: it has a schema other than ours, or is damaged.
    """
    frames = bundle.manifest.frames
    check_untrusted(bundle.folder / EVIDENCE / DATABASE, frames.stop - frames.start)
    return EvidenceReader(bundle.folder / EVIDENCE)


def _check_files(bundle: str, folder: Path, manifest: Manifest, names: list[str]) -> None:
    """Check that the bundle has exactly the files of its manifest, each with its hash."""
    listed = {entry.name: entry for entry in manifest.files}
    unpacked = set(names) - {MANIFEST}
    for name in (*_REQUIRED_FILES, manifest.clip.file):
        if name not in listed or name not in unpacked:
            raise ImportFormatError(f"{bundle}: {name} is missing. Copy the bundle again, or create it again.")
    for name in sorted(listed.keys() - unpacked):
        raise ImportFormatError(f"{bundle}: {name[:120]!r} is missing. Copy the bundle again.")
    for name in sorted(unpacked - listed.keys()):
        raise ImportFormatError(f"{bundle}: {name[:120]!r} is not in its {MANIFEST}. Create the bundle again.")
    for name, entry in listed.items():
        path = folder / name
        if path.stat().st_size != entry.size or file_sha256(path) != entry.sha256:
            raise ImportFormatError(
                f"{bundle}: {name} is not the file that {MANIFEST} names: its hash is another. Copy the bundle again."
            )
        if path.suffix in (".csv", ".json", ".txt") and entry.size > _MAX_TEXT_BYTES:
            raise ImportFormatError(f"{bundle}: {name} has {entry.size} bytes, at most {_MAX_TEXT_BYTES} are read.")
    network = manifest.network
    if network is not None and network.inside and (NETWORK not in listed or listed[NETWORK].sha256 != network.sha256):
        raise ImportFormatError(f"{bundle}: {NETWORK} is missing, or not the one of the run. Create the bundle again.")
    if listed[manifest.clip.file].sha256 != manifest.clip.sha256:
        raise ImportFormatError(f"{bundle}: {MANIFEST} names two hashes of the clip. Create the bundle again.")


def _read_frames(path: Path, manifest: Manifest) -> tuple[ClipFrame, ...]:
    frames: list[ClipFrame] = []
    wanted, offset = manifest.frames, manifest.clip.offset
    for number, row in islice(numbered_lines(path), 1, wanted.stop - wanted.start + 2):
        try:
            ordinal, clip, seconds, digest = int(row[0]), int(row[1]), float(row[2]), row[3]
        except (ValueError, IndexError):
            raise ImportFormatError(f"{path.name}, line {number}: is not a frame. Create the bundle again.") from None
        expected = wanted.start + len(frames)
        if ordinal != expected or clip != ordinal - offset or clip < 0 or not math.isfinite(seconds):
            raise ImportFormatError(
                f"{path.name}, line {number}: expected frame {expected}, number {expected - offset} of the clip. "
                "Create the bundle again."
            )
        frames.append(ClipFrame(ordinal, clip, seconds, digest))
    if len(frames) != wanted.stop - wanted.start:
        raise ImportFormatError(
            f"{path.name} lists {len(frames)} frames, expected {wanted.stop - wanted.start}. Create the bundle again."
        )
    return tuple(frames)
