"""Writes the report, Markdown and pictures, from stored results alone."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from benchmarks.experiment import Experiment, Result
from benchmarks.reporting.summary import summary

HEAD = """# What the engine does, measured

`python -m benchmarks` (`make bench`) writes every number on this page from `benchmarks/results/*.json` and draws the
pictures from the same files. An experiment that never ran says why. The last line of each section names the machine
that measured it: ratios of times carry over to other machines, milliseconds do not.

The paper is Yuan, Xiong and Wang, *An Incremental Framework for Video-Based Traffic Sign Detection, Tracking, and
Recognition* (2017). Its videos are not public, so its figures come from other data than ours; they are shown for
orientation.

No parameter was chosen on data that are called *held out*; parameters were chosen on the data called *chosen on*. A
*bar* is a value that must be reached, an *aim* is a goal beyond it. *Eq. 7* is the localisation error
`1 - intersection / larger area`; 0 is perfect. *KF* is the Kalman filter.

"""


def write_report(
    experiments: Sequence[Experiment], results: Path, figures: Path, page: Path, fresh: Collection[str] = ()
) -> None:
    """Write the page and its pictures.

    If an experiment has changed and cannot report its old result, the report names that result as left out and contains
    the others.

    Args:
        experiments: in the order of the page.
        results: folder of the JSON files.
        figures: folder of the pictures.
        page: the file to write.
        fresh: names of experiments whose results are new, so that they must be reportable.

    Raises:
        KeyError: an experiment cannot report its new result.
    """
    figures.mkdir(parents=True, exist_ok=True)
    parts = [HEAD, summary(results)]
    for experiment in experiments:
        parts.append(f"## {experiment.title}\n\n{experiment.question}\n\n")
        path = results / f"{experiment.name}.json"
        picture = figures / f"{experiment.name}.svg"
        if not path.is_file():
            parts.append("*Not run yet.*\n\n")
            continue
        result = Result.load(path)
        if result.skipped:
            picture.unlink(missing_ok=True)
            parts.append(f"*Skipped:* {result.skipped}\n\n")
            continue
        try:
            reported = experiment.report(result)
            if experiment.plot is not None:
                experiment.plot(result, picture)
        except KeyError as error:
            if experiment.name in fresh:
                raise
            picture.unlink(missing_ok=True)
            parts.append(
                f"*Skipped:* `{path.name}` is older than this experiment and lacks {error}; "
                f"`python -m benchmarks {experiment.name}` measures it again.\n\n"
            )
            continue
        parts.append(f"{result.data}\n\n{reported}\n")
        if experiment.plot is not None:
            parts.append(f"![{experiment.title}](figures/{picture.name})\n\n")
        for processor, headline in sorted(result.elsewhere.items()):
            parts.append(f"On {processor}: {headline}.\n\n")
        parts.append(f"{_where(result)}\n\n")
    page.write_text("".join(parts).rstrip() + "\n", encoding="utf-8")


def _where(result: Result) -> str:
    about = result.machine
    settings = ", ".join(f"{name} {value}" for name, value in sorted(result.settings.items()))
    packages = ", ".join(f"{name} {version}" for name, version in about.get("packages", {}).items() if version)
    return (
        f"<sub>`python -m benchmarks {result.name}`; {settings + '; ' if settings else ''}commit {about['commit']}; "
        f"{about['processor']}, {about['cores']} cores, load {about['load']} at the time; Python {about['python']}, "
        f"{packages}</sub>"
    )
