"""The interface that every format implements.

A format is a module with one ``Format`` object. Only the registry lists them, for the command line, the HTTP API and
the page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.small_file_store import SmallFileStore
from tsr_engine.labels.model import LabelSet

__all__ = [
    "BAD_BOXES",
    "ExportOptions",
    "Format",
    "ImportLimits",
    "ImportTarget",
    "Switch",
    "UnknownNames",
    "Writer",
    "Written",
]

UnknownNames = Literal["refuse", "add", "skip"]
Written = tuple[list[Skipped], dict[str, object]]
"""What a writer left out, and what the manifest should know."""


@dataclass(frozen=True, slots=True)
class Switch:
    """An option of one format that a person can set.

    Attributes:
        name: as in ``--option name=value``.
        values: what it can be; the first is what it is when nobody says.
        help: one sentence.
        free: any other text counts as well, such as a name that stands in the file.
    """

    name: str
    values: tuple[str, ...]
    help: str
    free: bool = False


BAD_BOXES = Switch(
    "bad_boxes",
    ("refuse", "skip"),
    "What to do with boxes without area or with coordinates that are missing or no numbers: refuse the file, or leave "
    "them out and tell how many.",
)
"""An option of every reader."""


@dataclass(frozen=True, slots=True)
class ExportOptions:
    """What an export should hold.

    Attributes:
        pictures: ``none``, ``annotated`` (frames that show a sign) or ``all``.
        switches: options of the format by name; all of them, defaults filled in.
        thin_px: dense tracks are thinned to key frames whose interpolation stays within this many px of each edge;
            formats that do not interpolate write every frame.
        split: subset of each (video sha256 or name, track uid), by ``tsr_engine.exchange.split``; empty: one subset.
        used_labels: declare the labels that signs have, not all that the set offers; numbers of labels then depend on
            what goes out.
        progress: told (frames or tracks done, of how many); raises to stop.
    """

    pictures: str = "none"
    switches: Mapping[str, str] = field(default_factory=dict)
    thin_px: float = 0.5
    split: Mapping[tuple[str, str], str] = field(default_factory=dict)
    used_labels: bool = False
    progress: Callable[[int, int], None] = lambda _done, _of: None


@dataclass(frozen=True, slots=True)
class ImportLimits:
    """What one import may hold; a few bytes of an archive, or of key frames, can stand for any number.

    Attributes:
        tracks: most tracks.
        boxes: most boxes, those between key frames too.
    """

    tracks: int = 1_000_000
    boxes: int = 10_000_000


@dataclass(frozen=True, slots=True)
class ImportTarget:
    """The video that an import belongs to; the reader checks the file against it.

    Attributes:
        video: its ``tracks`` are not read.
        labels: the label set of the video; see ``LabelMatcher`` for how names are matched.
        switches: options of the format; all of them, defaults filled in.
        label_map: name in the file -> id or key of a label, -1: none; said by a person, wins.
        remembered: what people said about names in earlier files; told where it counts.
        unknown: what becomes of names that no label has: ``refuse`` the file with their list, ``add`` them to the set
            with the attributes that the file declares, or ``skip`` their boxes.
        added: names that are added to the set, whatever ``unknown`` says of the others.
        wrapper: name of the folder in which the format begins, if that is not the chosen one; else empty.
        store: small files of an unpacked archive that are not on the disk; readers of such ask it.
        limits: what the import may hold.
        tell: called now and then with the number of boxes that have been read.
    """

    video: DatasetVideo
    labels: LabelSet
    switches: Mapping[str, str] = field(default_factory=dict)
    label_map: Mapping[str, int | str] = field(default_factory=dict)
    remembered: Mapping[str, int] = field(default_factory=dict)
    unknown: UnknownNames = "refuse"
    added: frozenset[str] = frozenset()
    wrapper: str = ""
    store: SmallFileStore | None = field(default=None, repr=False, compare=False)
    limits: ImportLimits = field(default_factory=ImportLimits)
    tell: Callable[[int], None] | None = field(default=None, repr=False, compare=False)


class Writer(Protocol):
    """Writes the files of a data set and says what it left out, and what the manifest should know."""

    def __call__(self, dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
        """Raises ``ExportError`` with one sentence where the format cannot hold the data (variable frame rate...)."""
        ...


class Reader(Protocol):
    """Reads a folder (an unpacked archive) or a single file."""

    def __call__(self, path: Path, target: ImportTarget) -> Dataset:
        """Gives one video with its tracks and ``skipped``; raises ``ImportFormatError`` with file, line and rule."""
        ...


@dataclass(frozen=True, slots=True)
class Format:
    """One format.

    Attributes:
        name: ``cvat-video``, ``cvat-images``, ``coco``, ``yolo``, ``voc``, ``mot``, ``gtsrb``, ``gtsdb``, ``datumaro``,
            ``label-studio``, ``tracks-csv``, ``tracks-json``.
        title: for people.
        summary: one sentence.
        write: None: import only.
        read: None: export only.
        sniff: looks at a folder or file and says whether it is of this format; cheap.
        export_switches: options of the writer.
        import_switches: options of the reader; ``BAD_BOXES`` is added to them.
        needs_pictures: an export without pictures makes no sense (crop folders).
        key_frames: the writer marks key frames, and ``ExportOptions.thin_px`` decides how many there are.
        attributes: which attributes of labels it holds: ``all``, those of whole ``tracks``, or ``none``.
        ignores: it has a mark for boxes to ignore; without one they are left out.
        docs: page under ``docs/formats/``.
    """

    name: str
    title: str
    summary: str
    write: Writer | None
    read: Reader | None
    sniff: Callable[[Path], bool]
    export_switches: tuple[Switch, ...] = ()
    import_switches: tuple[Switch, ...] = ()
    needs_pictures: bool = False
    key_frames: bool = False
    attributes: Literal["all", "tracks", "none"] = "all"
    ignores: bool = True
    docs: str = ""

    def __post_init__(self) -> None:
        if self.read is not None:
            object.__setattr__(self, "import_switches", (*self.import_switches, BAD_BOXES))
