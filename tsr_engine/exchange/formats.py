"""The interface that every format implements.

A format is a module with one ``Format`` object. The registry lists them for the command line, the HTTP API and the
page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from tsr_engine.errors import ExportError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo, Skipped
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.small_file_store import SmallFileStore
from tsr_engine.labels.model import LabelSet

UnknownNames = Literal["refuse", "add", "skip"]
Written = tuple[list[Skipped], dict[str, object]]
"""What a writer left out, and its entries for the manifest."""


@dataclass(frozen=True, slots=True)
class Switch:
    """An option of a format.

    Attributes:
        name: as in ``--option name=value``.
        values: the allowed values; the first is the default.
        help: one sentence.
        free: whether any other text is allowed too, such as a name in the file.
    """

    name: str
    values: tuple[str, ...]
    help: str
    free: bool = False


BAD_BOXES = Switch(
    "bad_boxes",
    ("refuse", "skip"),
    "What to do with boxes without area, or with missing or non-numeric coordinates: refuse the file, or leave them "
    "out and report their number.",
)
"""An option of every reader."""


@dataclass(frozen=True, slots=True)
class ExportOptions:
    """What an export holds.

    Attributes:
        pictures: ``none``, ``annotated`` (frames with a sign) or ``all``.
        switches: all options of the format by name, with defaults filled in.
        thin_px: dense tracks are thinned to key frames from which interpolation restores each edge within this many px;
            formats without interpolation write every frame.
        split: subset of each (video sha256 or name, track uid), by ``tsr_engine.exchange.split``; empty: one subset.
        used_labels: declare only labels that signs have, not all of the set; label numbers then depend on the exported
            tracks.
        progress: called with (frames or tracks done, total); may raise to stop.
    """

    pictures: str = "none"
    switches: Mapping[str, str] = field(default_factory=dict)
    thin_px: float = 0.5
    split: Mapping[tuple[str, str], str] = field(default_factory=dict)
    used_labels: bool = False
    progress: Callable[[int, int], None] = lambda _done, _of: None


@dataclass(frozen=True, slots=True)
class ImportLimits:
    """Limits of one import: a few bytes of an archive, or a few key frames, can expand to any number of boxes.

    Attributes:
        tracks: largest number of tracks.
        boxes: largest number of boxes, with those between key frames.
    """

    tracks: int = 1_000_000
    boxes: int = 10_000_000


@dataclass(frozen=True, slots=True)
class ImportTarget:
    """The video that an import belongs to; the reader checks the file against it.

    Attributes:
        video: the video; its ``tracks`` are not read.
        labels: the label set of the video; see ``LabelMatcher`` for how names are matched.
        switches: all options of the format, with defaults filled in.
        label_map: name in the file -> id or key of a label, -1: none; a person's choice, which precedes all others.
        remembered: choices for names in earlier files; each use is reported.
        unknown: treatment of names that match no label: ``refuse`` the file with a list of them, ``add`` them to the
            set with the attributes that the file declares, or ``skip`` their boxes.
        added: names to add to the set whatever ``unknown`` says.
        wrapper: name of the inner folder in which the format begins; empty: it is the chosen folder.
        store: small files of an unpacked archive that are not on the disk.
        limits: limits of the import.
        progress: called now and then with the number of boxes read.
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
    progress: Callable[[int], None] | None = field(default=None, repr=False, compare=False)


Writer = Callable[[Dataset, OutputSink, ExportOptions], Written]
"""Writes the files of a data set; raises ``ExportError`` with one sentence if the format cannot hold the data."""
Reader = Callable[[Path, ImportTarget], Dataset]
"""Reads a folder (an unpacked archive) or a file: one video; raises ``ImportFormatError`` with file, line and rule."""


@dataclass(frozen=True, slots=True)
class Format:
    """A file format.

    Attributes:
        name: ``cvat-video``, ``cvat-images``, ``coco``, ``yolo``, ``voc``, ``mot``, ``gtsrb``, ``gtsdb``, ``datumaro``,
            ``label-studio``, ``tracks-csv``, ``tracks-json``.
        title: name for people.
        summary: one sentence.
        write: None: import only.
        read: None: export only.
        sniff: whether a folder or file is of this format; fast.
        export_switches: the writer's options.
        import_switches: the reader's options; ``BAD_BOXES`` is added.
        needs_pictures: whether an export must have pictures (crop folders).
        allows_pictures: whether an export may have pictures.
        key_frames: whether the writer marks key frames; ``ExportOptions.thin_px`` decides how many there are.
        attributes: attributes that the format holds: ``all``, those of whole ``tracks``, or ``none``.
        ignores: whether it marks boxes to ignore; if not, they are left out.
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
    allows_pictures: bool = True
    key_frames: bool = False
    attributes: Literal["all", "tracks", "none"] = "all"
    ignores: bool = True
    docs: str = ""

    def __post_init__(self) -> None:
        if self.read is not None:
            object.__setattr__(self, "import_switches", (*self.import_switches, BAD_BOXES))

    def check_pictures(self, pictures: str) -> None:
        """Check whether an export may have these pictures; see ``ExportOptions.pictures``.

        Raises:
            ExportError: the format consists of pictures, or has none.
        """
        if self.needs_pictures and pictures == "none":
            raise ExportError(f"{self.title} consists of pictures. Export with pictures of the annotated frames.")
        if not self.allows_pictures and pictures != "none":
            raise ExportError(f"{self.title} has no pictures. Export without pictures.")
