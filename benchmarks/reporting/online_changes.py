"""The effect of the online detector, over only the frames in which ``default`` and the filter alone differ."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.reporting.markdown import number, table
from tsr_engine.json_shapes import JsonMapping


def online_changes(groups: Mapping[str, JsonMapping]) -> str:
    """Table of ``changed_errors`` of ``default`` against KF alone, one row per group; a sentence for unchanged groups.

    Args:
        groups: name of the row -> result of ``changed_errors``.
    """
    changed = {name: c for name, c in groups.items() if c["n"] or c["only_ours"] or c["only_theirs"]}
    same = [name for name in groups if name not in changed]
    parts = []
    if changed:
        rows = [["the online detector's part", "boxes changed", "Eq. 7 with it", "without it", "covered only with it",
                 "only without it"]]  # fmt: skip
        rows += [
            [name, str(c["n"]), number(c["ours"], 4), number(c["theirs"], 4), str(c["only_ours"]),
             str(c["only_theirs"])]
            for name, c in changed.items()
        ]  # fmt: skip
        parts.append(
            table(rows) + "\nThe rows count signs and frames in which `default` and KF alone have different boxes: Eq. "
            "7 where both cover the sign, and the frames that only one of them covers.\n"
        )
    if same:
        parts.append(f"The online detector changed no box of a sign on {', '.join(same)}.\n")
    return "\n".join(parts)
