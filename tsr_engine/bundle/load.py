"""Opens a bundle from another person; everything in it is checked before it is used."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from tsr_engine.bundle.expectation import Expectation, read_expectation
from tsr_engine.bundle.layout import CORRECTIONS, EVIDENCE, EXPECTATION, FRAMES, MANIFEST, NETWORK, OUTPUT, README
from tsr_engine.bundle.manifest import Manifest
from tsr_engine.bundle.output import Output, read_rows
from tsr_engine.errors import ImportFormatError, TsrError
from tsr_engine.evidence import EvidenceReader
from tsr_engine.evidence.foreign import check_foreign
from tsr_engine.evidence.schema import DATABASE
from tsr_engine.exchange.archive import ArchiveLimits, unpack
from tsr_engine.io.digest import file_sha256
from tsr_engine.io.video_probe import check_file

__all__ = ["LIMITS", "Bundle", "BundleFrame", "is_bundle", "open_bundle", "open_evidence"]

LIMITS = ArchiveLimits(
    entries=200,
    total=8 << 30,
    single=4 << 30,
    directory=1 << 20,
    advice="So it is no bug bundle; if it is an export, 'tsr import' reads it.",
)
"""What a bundle may unfold to."""
_NEEDED = (README, FRAMES, OUTPUT, EXPECTATION, CORRECTIONS, f"{EVIDENCE}/run.json", f"{EVIDENCE}/evidence.sqlite")
_TEXT_BYTES = 64 << 20
"""Largest text file that is read into memory."""


@dataclass(frozen=True, slots=True)
class BundleFrame:
    """One frame that the engine takes.

    Attributes:
        ordinal: in the original video.
        clip: in the clip.
        seconds: presentation time in the original video.
        digest: of the decoded picture.
    """

    ordinal: int
    clip: int
    seconds: float
    digest: str


@dataclass(frozen=True, slots=True)
class Bundle:
    """An unpacked bundle whose files are those of its manifest.

    Attributes:
        name: of the file.
        folder: where it was unpacked.
        manifest: its manifest.
        frames: all frames that the engine takes.
        expectation: what should have come out.
        output: what came out when it was made.
    """

    name: str
    folder: Path
    manifest: Manifest
    frames: tuple[BundleFrame, ...]
    expectation: Expectation
    output: Output

    @property
    def clip(self) -> Path:
        """The piece of video."""
        return self.folder / self.manifest.clip.file


def is_bundle(path: Path) -> bool:
    """Whether a path is to be opened as a bundle: it is a file, or is named like one."""
    return path.is_file() or path.suffix.lower() == ".zip"


@contextmanager
def open_bundle(path: Path, scratch: Path | None = None) -> Iterator[Bundle]:
    """Unpack and check a bundle; it is gone when the block ends.

    Args:
        path: the zip file.
        scratch: where to unpack; unset: the system's folder for temporary files.

    Raises:
        ImportFormatError: no bundle, a hostile or damaged one, or one of another format; names what and why.
    """
    if not path.is_file():
        raise ImportFormatError(f"There is no bundle at {path}. Check the path.")
    with TemporaryDirectory(prefix="tsr-bundle-", dir=scratch) as name:
        try:
            yield read_bundle(path, Path(name))
        except TsrError as error:
            # Where it was unpacked means nothing to anybody, and is gone.
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
        raise ImportFormatError(f"{EXPECTATION} is about frames that are not in the bundle. Make it anew.")
    output = Output.of(read_rows(folder / OUTPUT), manifest.frames.first, manifest.frames.stop)
    return Bundle(path.name, folder, manifest, frames, expectation, output)


def open_evidence(bundle: Bundle) -> EvidenceReader:
    """The evidence in a bundle, after a check that it is safe to read.

    Raises:
        EvidenceError: it holds what ours never does, or is damaged.
    """
    frames = bundle.manifest.frames
    check_foreign(bundle.folder / EVIDENCE / DATABASE, frames.stop - frames.start)
    return EvidenceReader(bundle.folder / EVIDENCE)


def _check_files(bundle: str, folder: Path, manifest: Manifest, names: list[str]) -> None:
    """Exactly the files of the manifest, each with its hash."""
    listed = {entry.name: entry for entry in manifest.files}
    there = set(names) - {MANIFEST}
    for name in (*_NEEDED, manifest.clip.file):
        if name not in listed or name not in there:
            raise ImportFormatError(f"{bundle}: {name} is missing. Copy the bundle again, or make it anew.")
    for name in sorted(listed.keys() - there):
        raise ImportFormatError(f"{bundle}: {name[:120]!r} is missing. Copy the bundle again.")
    for name in sorted(there - listed.keys()):
        raise ImportFormatError(f"{bundle}: {name[:120]!r} is not in its {MANIFEST}. Make the bundle anew.")
    for name, entry in listed.items():
        path = folder / name
        if path.stat().st_size != entry.size or file_sha256(path) != entry.sha256:
            raise ImportFormatError(
                f"{bundle}: {name} is not the file that {MANIFEST} names: its hash is another. Copy the bundle again."
            )
        if path.suffix in (".csv", ".json", ".txt") and entry.size > _TEXT_BYTES:
            raise ImportFormatError(f"{bundle}: {name} has {entry.size} bytes, at most {_TEXT_BYTES} are read.")
    network = manifest.network
    if network is not None and network.inside and (NETWORK not in listed or listed[NETWORK].sha256 != network.sha256):
        raise ImportFormatError(f"{bundle}: {NETWORK} is missing, or not the one of the run. Make the bundle anew.")
    if listed[manifest.clip.file].sha256 != manifest.clip.sha256:
        raise ImportFormatError(f"{bundle}: {MANIFEST} names two hashes of the clip. Make the bundle anew.")


def _read_frames(path: Path, manifest: Manifest) -> tuple[BundleFrame, ...]:
    frames: list[BundleFrame] = []
    wanted, offset = manifest.frames, manifest.clip.offset
    with path.open(encoding="utf-8", errors="replace", newline="") as stream:
        for number, row in enumerate(csv.reader(stream), 1):
            if number == 1:
                continue
            try:
                ordinal, clip, seconds, digest = int(row[0]), int(row[1]), float(row[2]), row[3]
            except (ValueError, IndexError):
                raise ImportFormatError(f"{path.name}, line {number}: is no frame. Make the bundle anew.") from None
            expected = wanted.start + len(frames)
            if ordinal != expected or clip != ordinal - offset or clip < 0 or not math.isfinite(seconds):
                raise ImportFormatError(
                    f"{path.name}, line {number}: expected frame {expected}, number {expected - offset} of the clip. "
                    "Make the bundle anew."
                )
            frames.append(BundleFrame(ordinal, clip, seconds, digest))
            if len(frames) > wanted.stop - wanted.start:
                break
    if len(frames) != wanted.stop - wanted.start:
        raise ImportFormatError(
            f"{path.name} lists {len(frames)} frames, expected {wanted.stop - wanted.start}. Make the bundle anew."
        )
    return tuple(frames)
