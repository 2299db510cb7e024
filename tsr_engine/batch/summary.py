"""Summarises a batch as JSON for programs and HTML for people."""

from __future__ import annotations

import html
import json
from collections import Counter
from pathlib import Path
from typing import Final

from tsr_engine.batch.html_page import html_page
from tsr_engine.batch.manifest import Manifest
from tsr_engine.io.atomic import atomic_text
from tsr_engine.json_shapes import JsonObject

SUMMARY_JSON: Final = "summary.json"
SUMMARY_HTML: Final = "summary.html"
_MAX_UNSURE_SHARE: Final = 0.6
"""Signs whose class has a lower share of the votes are listed as unsure."""
_MAX_LISTED: Final = 500
_TRACK_FIGURES: Final = ("class_name", "share", "first_frame", "last_frame")


def summary_of(manifest: Manifest) -> JsonObject:
    """Figures of all drives of a batch.

    Returns:
        ``drives``, ``done``, ``failed``, ``waiting``: counts; ``frames``, ``seconds``; ``signs``: by class name;
        ``unsure``: signs whose class has a low share of the votes, lowest first; ``failures``: drive and sentence;
        ``drive_list``: drive, folder, frames, signs, warnings.
    """
    done = [drive for drive in manifest.drives if drive.state == "done"]
    tracks = [(drive, track) for drive in done for track in drive.result["tracks"]]
    unsure = sorted(
        (row for row in tracks if row[1]["share"] < _MAX_UNSURE_SHARE), key=lambda row: (row[1]["share"], row[0].folder)
    )
    states = Counter(drive.state for drive in manifest.drives)
    return {
        "version": manifest.identity.version,
        "models": manifest.identity.models,
        "drives": len(manifest.drives),
        **{state: states[state] for state in ("done", "failed", "waiting")},
        "frames": sum(drive.result["frames"] for drive in done),
        "seconds": round(sum(drive.result["seconds"] for drive in done), 1),
        "signs": dict(Counter(track["class_name"] for _, track in tracks).most_common()),
        "unsure": [
            {"drive": drive.folder, "track": track["track_id"], **{name: track[name] for name in _TRACK_FIGURES}}
            for drive, track in unsure
        ],
        "failures": [
            {"drive": drive.video, "error": drive.error} for drive in manifest.drives if drive.state == "failed"
        ],
        "drive_list": [
            {
                "drive": drive.video,
                "folder": drive.folder,
                "frames": drive.result["frames"],
                "signs": len(drive.result["tracks"]),
                "warnings": drive.result["warnings"],
            }
            for drive in done
        ],
    }


def write_summary(manifest: Manifest, out: Path) -> None:
    """Write ``summary.json`` and ``summary.html`` into the folder of a batch.

    Raises:
        StorageError: the folder cannot be written.
    """
    summary = summary_of(manifest)
    with atomic_text(out / SUMMARY_JSON) as file:
        json.dump(summary, file, indent=1, allow_nan=False)
    with atomic_text(out / SUMMARY_HTML) as file:
        file.write(_page(summary))


def _page(summary: JsonObject) -> str:
    minutes = summary["seconds"] / 60
    head = (
        f"<p>{summary['done']} of {summary['drives']} drives are done, {summary['failed']} failed, "
        f"{summary['waiting']} wait. {summary['frames']} frames took {minutes:.1f} minutes of processes with "
        f"tsr {html.escape(summary['version'])}.</p>"
    )
    signs = _table(("sign", "signs"), [(name, count) for name, count in summary["signs"].items()])
    failures = _table(("drive", "why"), [(row["drive"], row["error"]) for row in summary["failures"]])
    unsure = _table(
        ("drive", "track", "sign", "share of votes", "frames"),
        [
            (
                r["drive"],
                r["track"],
                r["class_name"],
                f"{100 * r['share']:.0f} %",
                f"{r['first_frame']}-{r['last_frame']}",
            )
            for r in summary["unsure"][:_MAX_LISTED]
        ],
    )
    drives = _table(
        ("drive", "results", "frames", "signs", "warnings"),
        [(r["drive"], r["folder"], r["frames"], r["signs"], "; ".join(r["warnings"])) for r in summary["drive_list"]],
    )
    more = len(summary["unsure"]) - _MAX_LISTED
    rest = f"<p>{more} more stand in {SUMMARY_JSON}.</p>" if more > 0 else ""
    body = f"{head}<h2>Failures</h2>{failures}<h2>Signs</h2>{signs}<h2>Unsure</h2>{unsure}{rest}<h2>Drives</h2>{drives}"
    return html_page("tsr batch", "Batch", body)


def _table(names: tuple[str, ...], rows: list[tuple[object, ...]]) -> str:
    if not rows:
        return "<p>None.</p>"

    def cell(tag: str, value: object) -> str:
        kind = ' class="n"' if isinstance(value, int | float) else ""
        return f"<{tag}{kind}>{html.escape(str(value))}</{tag}>"

    head = "".join(cell("th", name) for name in names)
    body = "".join(f"<tr>{''.join(cell('td', value) for value in row)}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
