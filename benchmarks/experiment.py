"""Types of experiments, their data and results, and the description of the machine."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib import metadata
from pathlib import Path

from tsr_engine.json_shapes import JsonMapping, JsonObject

ROOT = Path(__file__).resolve().parent


class Skip(Exception):
    """The experiment cannot run here; the report shows the sentence."""


@dataclass(frozen=True, slots=True)
class Data:
    """Folders of the data, each an option of ``python -m benchmarks``; None: not given.

    Attributes:
        scratch: intermediate files of experiments, which later calls use again.
        seed: random seed.
        seconds: time that one call may spend on a long drive; None: the experiment's default.
    """

    gtsdb: Path | None = field(default=None, metadata={"help": "scenes with gt.txt"})
    gtsrb: Path | None = field(default=None, metadata={"help": "class folders 00000 to 00042"})
    clips: Path | None = field(default=None, metadata={"help": "annotated clips with ground truth in gt/"})
    looming: Path | None = field(default=None, metadata={"help": "simulated approaches with clips.json"})
    scratch: Path = Path("out/bench")
    seed: int = 0
    tuning: Path | None = field(default=None, metadata={"help": "simulated approaches that parameters were chosen on"})
    seconds: float | None = None
    boards: Path | None = field(default=None, metadata={"help": "simulated approaches to signs of no label set"})
    before: Path | None = field(
        default=None, metadata={"help": "checkout of an earlier version, for `day` and `first_sight`"}
    )
    foreign: Path | None = field(
        default=None, metadata={"help": "folders of pictures of other countries, each with boxes.json"}
    )
    drives: Path | None = field(default=None, metadata={"help": "videos without annotation"})

    def has(self, name: str) -> bool:
        """Whether a folder was given and exists."""
        folder: Path | None = getattr(self, name)
        return folder is not None and folder.is_dir()

    def need(self, name: str) -> Path:
        """A folder of data.

        Raises:
            Skip: it was not given or does not exist.
        """
        if not self.has(name):
            raise Skip(f"no data: the folder `{name}` was not given or does not exist.")
        folder: Path = getattr(self, name)
        return folder


@dataclass(frozen=True, slots=True)
class Result:
    """The result of an experiment.

    Attributes:
        name: name of the experiment, set by ``python -m benchmarks``.
        data: one sentence about the data and their split.
        figures: figures as JSON values.
        settings: seeds, models, parameters.
        machine: description of the machine, see ``machine``.
        skipped: why it did not run; empty: it ran.
        elsewhere: short results on other processors, by their name; see ``beside``.
        folders: the folders among the experiment's ``optional`` ones that it used; None: an older result, not known.
    """

    name: str = ""
    data: str = ""
    figures: JsonMapping = field(default_factory=dict)
    settings: JsonMapping = field(default_factory=dict)
    machine: JsonMapping = field(default_factory=dict)
    skipped: str = ""
    elsewhere: Mapping[str, str] = field(default_factory=dict)
    folders: Sequence[str] | None = None

    def beside(self, other: Result | None, headline: Callable[[Result], str]) -> Result:
        """This result with a short form of another one, and of what that has beside it, from other processors."""
        if other is None or other.skipped or self.skipped:
            return self
        here, there = self.machine["processor"], other.machine["processor"]
        short = f"{headline(other)} (commit {other.machine['commit']})"
        found = {**self.elsewhere, **other.elsewhere, there: short}
        found.pop(here, None)
        return replace(self, elsewhere=found)

    def save(self, folder: Path) -> None:
        """Write ``NAME.json``."""
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(asdict(self), indent=1, allow_nan=False, sort_keys=True)
        (folder / f"{self.name}.json").write_text(text + "\n", encoding="utf-8")

    @staticmethod
    def load(path: Path) -> Result:
        """Read a result file."""
        return Result(**json.loads(path.read_text(encoding="utf-8")))


@dataclass(frozen=True, slots=True)
class Experiment:
    """One experiment.

    Attributes:
        name: short name; also names the files.
        title: heading in the report.
        question: the question that it answers, one paragraph.
        run: runs it; raises ``Skip`` if that is impossible.
        report: writes the report's text about its figures, Markdown.
        plot: draws ``NAME.svg``; None: there is no figure.
        headline: one clause with the figures that depend on the processor, which the report keeps after a run on
            another one; None: no figure depends on it.
        optional: names of folders without which it runs, but with fewer figures.
    """

    name: str
    title: str
    question: str
    run: Callable[[Data], Result]
    report: Callable[[Result], str]
    plot: Callable[[Result, Path], None] | None = None
    headline: Callable[[Result], str] | None = None
    optional: tuple[str, ...] = ()


def machine() -> JsonObject:
    """Processor, cores that the process may use, versions, commit, and how busy the machine was."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.is_file() else []
    model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "")
    packages = ("numpy", "numba", "opencv-python-headless", "scikit-learn", "av", "tsr")
    return {
        "processor": model or platform.processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load": round(os.getloadavg()[0], 1),
        "python": platform.python_version(),
        "packages": {name: version(name) for name in packages},
        "commit": _commit(),
    }


def version(package: str) -> str:
    """The installed version of a package; empty if it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""


def _commit() -> str:
    """The commit, with ``-dirty`` if the code differs from it; files that experiments write do not count."""
    written = [f":(top,exclude){ROOT.name}/{name}" for name in ("results", "figures", "REPORT.md")]
    commit = _git("describe", "--always")
    changed = _git("status", "--porcelain", "--untracked-files=no", "--", ":(top)", *written)
    return f"{commit}-dirty" if commit and changed else commit


def _git(*arguments: str) -> str:
    try:
        found = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)  # noqa: S603, S607
    except OSError:
        return ""
    return found.stdout.strip()
