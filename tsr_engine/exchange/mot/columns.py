"""Finds the meaning of the columns after the box in a MOT file.

All such files begin with frame, id, x, y, width and height. The columns after these depend on the tool:

=========== ===== ================================================================
``truth``   9     1 or 0 to ignore, class from 1, visibility (MOTChallenge, CVAT)
``boxmot``  9     1, class from 0, score (BoxMOT)
``results`` 7, 10 score, and three positions in space or -1 (MOTChallenge)
``visdrone`` 10   1 or 0 to ignore, or a score; VisDrone's category, truncation, occlusion (-1 in results)
=========== ===== ================================================================

The file does not name the tool. The import decides by the values and the files beside it, and reports the choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tsr_engine.exchange.formats import Switch
from tsr_engine.plural import plural

COLUMNS_SWITCH = Switch(
    "columns",
    ("auto", "truth", "boxmot", "results", "visdrone"),
    "Columns after the box: flag, class, visibility; flag, class, score; score, positions; VisDrone's. auto: by the "
    "values and the files beside.",
)
SCORES_SWITCH = Switch(
    "scores", ("refuse", "drop"), "Scores outside 0 to 1, as MOTChallenge's detectors write them: leave them out."
)
VISDRONE = (
    *("ignored regions", "pedestrian", "people", "bicycle", "car", "van", "truck", "tricycle", "awning-tricycle"),
    *("bus", "motor", "others"),
)
"""Names of VisDrone's categories, from 0."""
_COLUMN_COUNTS = {"truth": (9,), "boxmot": (9,), "results": (7, 10), "visdrone": (10,)}
MIN_VISIBILITY = 0.5
"""Signs with a lower visibility count as hidden."""

Row = Sequence[float]
Rows = Sequence[Row]


@dataclass(frozen=True, slots=True)
class Columns:
    """Index of each column from 0; None: there is no such column.

    Attributes:
        flag: 0 to ignore the box.
        score: 0 to 1, -1: no score.
        label: number of the class.
        visibility: visible share of the sign, 0 to 1.
        occlusion: VisDrone's, 0 to 2.
        names: class names from 0; None: in the file beside, or unknown.
        first_class: number of the first class unless a person chooses it.
        report: the report of the choice; empty: the choice is certain.
    """

    flag: int | None = None
    score: int | None = None
    label: int | None = None
    visibility: int | None = None
    occlusion: int | None = None
    names: tuple[str, ...] | None = None
    first_class: int = 1
    report: str = ""


def find_columns(
    rows: Rows, option: str, *, is_ground_truth: bool, has_names: bool, is_own_export: bool = False
) -> Columns | None:
    """Find the meaning of the columns of a file.

    Args:
        rows: all rows of the file as numbers, of one width: 7, 9 or 10; at least one.
        option: the value of the switch ``columns``.
        is_ground_truth: whether the file's name or place marks it as ground truth.
        has_names: whether a list of class names lies beside it.
        is_own_export: whether our manifest lies beside it.

    Returns:
        None: the file has another number of columns than ``option`` needs.
    """
    width = len(rows[0])
    if option != "auto" and width not in _COLUMN_COUNTS[option]:
        return None
    if width == 9:
        return _nine_columns(
            rows, option, is_ground_truth=is_ground_truth, has_names=has_names, is_own_export=is_own_export
        )
    return _ten_columns(rows, option, has_names=has_names) if width == 10 else Columns(score=6)


def _nine_columns(rows: Rows, option: str, *, is_ground_truth: bool, has_names: bool, is_own_export: bool) -> Columns:
    sure = is_ground_truth or has_names
    seen = {row[8] for row in rows}
    plain = seen <= {-1.0, 0.0, 1.0}
    # Most visibilities of ground truth are 1; a score of exactly 0 or 1 is rare.
    kind = option if option != "auto" else "truth" if sure or plain or seen & {0.0, 1.0} else "boxmot"
    if kind == "boxmot":
        report = "Column 9 was taken as a score, column 8 as a class from 0, as BoxMOT writes them"
        report += "; with columns=truth column 9 is a visibility" if option == "auto" else ""
        return Columns(flag=6, label=7, score=8, first_class=0, report=report)
    hidden = sum(0 <= row[8] < MIN_VISIBILITY for row in rows)
    report = ""
    if option == "auto" and (not plain or (hidden and not sure) or (hidden == len(rows) and not is_own_export)):
        below = plural(hidden, "box", "boxes")
        report = f"Column 9 was taken as the visibility, {below} below {MIN_VISIBILITY} came in as hidden"
        report += "; with columns=boxmot it is a score"
    first = 0 if not has_names and any(row[7] == 0 for row in rows) else 1
    return Columns(flag=6, label=7, visibility=8, first_class=first, report=report)


def _ten_columns(rows: Rows, option: str, *, has_names: bool) -> Columns:
    rest = [tuple(row[7:]) for row in rows]
    unused = all(cells == (-1.0, -1.0, -1.0) for cells in rest)
    classes = {cells[0] for cells in rest}
    listed = classes <= {float(number) for number in range(len(VISDRONE))}
    flags = {row[6] for row in rows} <= {0.0, 1.0}
    occluded = all(cells[1] in (0, 1) and cells[2] in (0, 1, 2) for cells in rest)
    of_results = all(cells[1:] == (-1.0, -1.0) for cells in rest)
    is_ground_truth = listed and flags and occluded and any(any(cells) for cells in rest)
    found = listed and not unused and (is_ground_truth or (of_results and (has_names or 0.0 not in classes)))
    kind = option if option != "auto" else "visdrone" if found else "results"
    if kind == "results":
        uncertainty = option == "auto" and not unused
        report = (
            "Columns 8 to 10 were taken as positions in space and not read; with columns=visdrone they are VisDrone's"
        )
        return Columns(score=6, report=report if uncertainty else "")
    what = "column 8 was taken as the class" + ("" if has_names else " of VisDrone's list (4 is a car)")
    if of_results:
        report = f"Ten columns: {what}, column 7 as a score"
    else:
        report = (
            f"Ten columns: {what}, column 9 as truncation, column 10 as occlusion (2 is hidden), as VisDrone has them"
        )
    report += "; with columns=results they are positions in space" if option == "auto" else ""
    names = None if has_names else VISDRONE
    if of_results:
        return Columns(score=6, label=7, names=names, first_class=0 if names else 1, report=report)
    return Columns(flag=6, label=7, occlusion=9, names=names, first_class=0 if names else 1, report=report)
