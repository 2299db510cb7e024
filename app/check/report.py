"""A check as JSON for programs, as HTML with crops for people, and its worst places as bug bundles."""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from app.check.figures import FIGURES
from app.check.regressions import Regression
from app.check.run import CheckedDrive, CheckReport
from tsr_engine.batch.html_page import html_page
from tsr_engine.bundle import Bounds, BundleRequest, Expectation, Expected, ExpectedSign, make_bundle
from tsr_engine.errors import TsrError
from tsr_engine.io.atomic import atomic_text
from tsr_engine.io.video import open_video
from tsr_engine.json_shapes import JsonObject
from tsr_engine.labels.model import LabelSet
from tsr_engine.records import Picture

CHECK_JSON: Final = "check.json"
CHECK_HTML: Final = "check.html"
_CROPS: Final = "crops"
_MAX_CROPS: Final = 200
_MAX_CROP_SIDE: Final = 160
"""Side of a crop, px."""
_MARGIN_FRAMES: Final = 15
"""Frames before and after a place that its bundle holds."""
_STYLE: Final = """
th, td { vertical-align: middle }
.over { color: #c22; font-weight: 600 }
img { display: block; width: 96px; height: 96px; object-fit: cover }
"""


def describe_regression(place: Regression, drives: Sequence[CheckedDrive]) -> str:
    """Describe in one sentence what got worse at a place."""
    source = drives[place.drive].reviewed.source
    drive, labels = source.video.name, source.classes.labels
    frames = f"frames {place.first} to {place.last}"
    sign = "a sign" if place.class_id is None else _name(labels, place.class_id)
    read = "no class" if place.got is None else _name(labels, place.got)
    if place.kind == "lost":
        return f"{drive}: {sign} is no longer found ({frames})."
    if place.kind == "misread":
        return f"{drive}: {sign} is now read as {read} ({frames})."
    if place.kind == "false":
        return f"{drive}: a new false track, read as {read} ({frames})."
    return f"{drive}: {sign} is covered in {100 * place.weight:.0f} % fewer of its frames ({frames})."


def _name(labels: LabelSet, label_id: int) -> str:
    label = labels.get(labels.resolved(label_id))
    return f"label {label_id}" if label is None else label.name


def as_json(report: CheckReport) -> JsonObject:
    """Convert the report to JSON values."""
    return {
        "drives": [
            {
                "video": str(drive.path),
                "run": drive.reviewed.source.run_id,
                "decided": drive.reviewed.decided,
                "signs": len(drive.after.signs),
                "results": str(drive.folder),
            }
            for drive in report.drives
        ],
        "figures": {
            change.name: {
                "before": change.before,
                "after": change.after,
                "difference": change.difference,
                "interval": change.interval,
            }
            for change in report.changes
        },
        "intervals_over": report.unit,
        "over_budget": report.over,
        "places": [
            {
                "video": str(report.drives[place.drive].path),
                "kind": place.kind,
                "frame": place.frame,
                "frames": [place.first, place.last],
                "box": [round(edge, 1) for edge in place.box],
                "text": describe_regression(place, report.drives),
            }
            for place in report.places
        ],
        "failures": [{"video": video, "error": error} for video, error in report.failures],
    }


def write_report(report: CheckReport, out: Path) -> None:
    """Write ``check.json``, ``check.html`` and the crops of the worst places.

    Raises:
        StorageError: the folder cannot be written.
        VideoError: a video can no longer be read.
    """
    crops = _write_crops(report, out)
    with atomic_text(out / CHECK_JSON) as file:
        json.dump(as_json(report), file, indent=1, ensure_ascii=False, allow_nan=False)
    with atomic_text(out / CHECK_HTML) as file:
        file.write(_page(report, crops))


def write_bundles(report: CheckReport, out: Path, limit: int, warn: Callable[[str], None]) -> list[Path]:
    """Pack the worst places as bug bundles; people's decisions are the expectation.

    Args:
        report: the check.
        out: folder of the bundles.
        limit: maximum number of bundles.
        warn: called with a sentence for each bundle that could not be made.

    Returns:
        The bundles that were made.
    """
    made: list[Path] = []
    for number, place in enumerate(report.places[:limit], start=1):
        drive = report.drives[place.drive]
        path = out / f"{number:02}-{place.kind}-{drive.folder.name}-{place.frame}.zip"
        source = drive.reviewed.source
        first, stop = (
            max(source.first, place.frame - _MARGIN_FRAMES),
            min(source.stop, place.frame + _MARGIN_FRAMES + 1),
        )
        try:
            make_bundle(
                BundleRequest(
                    evidence=drive.folder / "evidence",
                    video=drive.path,
                    out=path,
                    first=first,
                    stop=stop,
                    note=describe_regression(place, report.drives),
                    expectation=_expectation(place, drive, first, stop),
                    recording=False,
                )
            )
        except TsrError as error:
            warn(f"{path.name} could not be made: {error}")
            continue
        made.append(path)
    return made


def _expectation(place: Regression, drive: CheckedDrive, first: int, stop: int) -> Expectation:
    if place.kind == "false":
        sign = ExpectedSign(frames=[place.frame], boxes=[place.box])
        return Expectation(
            bounds=Bounds(), signs={"s": sign}, expected=[Expected(id="absent", kind="absent", sign="s")]
        )
    truth = drive.reviewed.truth
    rows = np.flatnonzero((truth.track == place.what) & ~truth.ignore & (truth.frame >= first) & (truth.frame < stop))
    boxes = [(x1, y1, x2, y2) for x1, y1, x2, y2 in truth.boxes[rows].tolist()]
    sign = ExpectedSign(frames=truth.frame[rows].tolist(), boxes=boxes)
    wanted = [Expected(id="found", kind="found", sign="s")]
    class_id = None if place.class_id is None else drive.classes.to_class(place.class_id)
    if place.kind == "misread" and class_id is not None:
        wanted.append(Expected(id="label", kind="label", sign="s", class_id=class_id))
    return Expectation(bounds=Bounds(), signs={"s": sign}, expected=wanted)


def _write_crops(report: CheckReport, out: Path) -> dict[int, str]:
    """Write the crops; return their paths relative to the folder, by index of the place."""
    names: dict[int, str] = {}
    shown = list(enumerate(report.places[:_MAX_CROPS]))
    if shown:
        (out / _CROPS).mkdir(parents=True, exist_ok=True)
    for number, drive in enumerate(report.drives):
        drive_places = sorted((place.frame, k, place) for k, place in shown if place.drive == number)
        if not drive_places:
            continue
        source = drive.reviewed.source
        with open_video(drive.path, limits=source.video.limits) as video:
            if source.video.table is not None:
                video.adopt(source.video.table)
            for frame, k, place in drive_places:
                picture = next(iter(video.frames(frame, frame + 1))).picture
                name = f"{_CROPS}/{k:03}.jpg"
                cv2.imwrite(str(out / name), _crop(picture, place), [cv2.IMWRITE_JPEG_QUALITY, 88])
                names[k] = name
    return names


def _crop(picture: Picture, place: Regression) -> Picture:
    """Crop a square around the box, with the box's size again as margin."""
    x1, y1, x2, y2 = place.box
    half = max(12.0, x2 - x1, y2 - y1)
    centre = ((x1 + x2) / 2, (y1 + y2) / 2)
    patch = cv2.getRectSubPix(picture, (round(2 * half), round(2 * half)), centre)
    scale = _MAX_CROP_SIDE / patch.shape[0]
    patch = cv2.resize(
        patch, (_MAX_CROP_SIDE, _MAX_CROP_SIDE), interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    )
    corner = [round(_MAX_CROP_SIDE / 2 - (c - e) * scale) for c, e in zip(centre, (x1, y1), strict=True)]
    far = [round(_MAX_CROP_SIDE / 2 + (e - c) * scale) for c, e in zip(centre, (x2, y2), strict=True)]
    cv2.rectangle(patch, (corner[0], corner[1]), (far[0], far[1]), (0, 200, 255), 1)
    return np.asarray(patch, np.uint8)


def _page(report: CheckReport, crops: dict[int, str]) -> str:
    escape = html.escape
    over = {text.partition(" ")[0] for text in report.over}
    rows = "".join(
        f"<tr{' class=over' if change.name in over else ''}><td>{escape(FIGURES[change.name][0])}</td>"
        f"{''.join(f'<td>{text}</td>' for text in change.shown())}</tr>"
        for change in report.changes
    )
    sentences = "".join(f'<p class="over">{escape(text)}</p>' for text in report.over)
    places = "".join(
        f"<tr><td>{_image(crops.get(k))}</td><td>{escape(describe_regression(place, report.drives))}</td>"
        f"<td>frame {place.frame}</td></tr>"
        for k, place in enumerate(report.places)
    )
    failures = "".join(f"<p>{escape(video)}: {escape(error)}</p>" for video, error in report.failures)
    signs = sum(len(drive.after.signs) for drive in report.drives)
    body = (
        f"<p>{len(report.drives)} reviewed drives with {signs} signs. Intervals hold 95 % of bootstrap samples of the "
        f"difference; the samples draw {report.unit}.</p>{sentences}"
        f"<table><thead><tr><th>figure<th>before<th>after<th>difference<th>interval</thead><tbody>{rows}</tbody></table>"
        f"<h2>Worse</h2>{f'<table>{places}</table>' if places else '<p>None.</p>'}"
        f"<h2>Failures</h2>{failures or '<p>None.</p>'}"
    )
    return html_page("tsr check", "Check", body, _STYLE)


def _image(name: str | None) -> str:
    return "" if name is None else f'<img src="{name}" alt="">'
