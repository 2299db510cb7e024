"""Compares an output with a person's expectations and with the output when the bundle was made."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from tsr_engine.bundle.expectation import Bounds, Expectation, Expected, ExpectedSign
from tsr_engine.bundle.layout import Verdict
from tsr_engine.bundle.output import Output


@dataclass(frozen=True, slots=True)
class Finding:
    """The verdict on one expectation, with a sentence on both sides and the frame to look at."""

    id: str
    met: bool
    expected: str
    got: str
    frame: int


def judge(expectation: Expectation, output: Output) -> list[Finding]:
    """Compare an output with all expectations, in their order."""
    findings = []
    for expected in expectation.expected:
        sign = expectation.signs[expected.sign]
        met, got, frame = _RULES[expected.kind](expected, sign, expectation, output)
        findings.append(Finding(expected.id, met, describe_expectation(expected, expectation), got, frame))
    return findings


def overall_verdict(old_findings: Sequence[Finding], new_findings: Sequence[Finding], same_output: bool) -> Verdict:
    """The verdict on a replay.

    * ``fixed``: there are expectations, and all are met;
    * ``still broken``: an expectation that failed when the bundle was made fails again;
    * ``unchanged``: there are no expectations, and the output is the same as before, with the reported problem;
    * ``different``: none of these. The earlier failures are gone, but another expectation fails; without expectations:
      the output has changed, and a person must look at it.

    Args:
        old_findings: findings of the output in the bundle.
        new_findings: findings of the replay, for the same expectations in the same order.
        same_output: whether the two outputs are the same.
    """
    if not new_findings:
        return "unchanged" if same_output else "different"
    if all(finding.met for finding in new_findings):
        return "fixed"
    failed = {finding.id for finding in old_findings if not finding.met}
    return "still broken" if any(not finding.met and finding.id in failed for finding in new_findings) else "different"


def describe_expectation(expected: Expected, expectation: Expectation) -> str:
    """An expectation as a sentence."""
    bounds = expectation.bounds
    sign = expectation.signs[expected.sign]
    span = f"frame {sign.frames[0]}" if len(sign.frames) == 1 else f"frames {sign.frames[0]} to {sign.frames[-1]}"
    sign_name = _sign_name(expected.sign, sign)
    if expected.kind == "found":
        return f"The sign {sign_name} ({span}) is found in at least {100 * bounds.share:.0f} % of its frames."
    if expected.kind == "label":
        return f"The sign {sign_name} ({span}) is labelled {expectation.class_name(expected.class_id)}."
    if expected.kind == "boxes":
        return (
            f"A box lies on the sign {sign_name} in {_frames(expected.frames)}; at most {bounds.eq7:g} of the two "
            "areas lies outside of their overlap (Eq. 7)."
        )
    if expected.kind == "absent":
        return f"Nothing is tracked where the box {sign_name} lies ({span}): there is no sign."
    if expected.kind == "one":
        return f"The sign {sign_name} ({span}) is one track."
    assert expected.other is not None
    other_name = _sign_name(expected.other, expectation.signs[expected.other])
    return f"The sign {sign_name} and the sign {other_name} are two tracks."


def _sign_name(key: str, sign: ExpectedSign) -> str:
    """The tool's number of an engine track; a track that a person drew is named by its first frame."""
    track = key.partition(" ")[0]  # a part that was cut off has a word after its track
    if track.startswith("m") and track[1:].isdecimal():
        return f"#{track[1:]}"
    return f"marked in frame {sign.frames[0]}" if track.startswith("h") else key


_Answer = tuple[bool, str, int]


def _found(expected: Expected, sign: ExpectedSign, expectation: Expectation, output: Output) -> _Answer:
    visible = sign.visible_boxes()
    missed = [frame for frame, box in visible if not output.tracks_on(frame, box, expectation.bounds.iou)]
    share = 1.0 - len(missed) / len(visible) if visible else 1.0
    met = share >= expectation.bounds.share
    return (
        met,
        f"A track lies on it in {len(visible) - len(missed)} of {len(visible)} frames.",
        sign.frames[0] if met or not missed else missed[0],
    )


def _label(expected: Expected, sign: ExpectedSign, expectation: Expectation, output: Output) -> _Answer:
    counts = _tracks_on(sign, expectation.bounds, output)
    if not counts:
        return False, "No track lies on it.", sign.frames[0]
    track = min(counts, key=lambda t: (-counts[t], t))
    label = output.class_of(track)
    return label == expected.class_id, f"Track {track} is labelled {expectation.class_name(label)}.", sign.frames[-1]


def _boxes(expected: Expected, sign: ExpectedSign, expectation: Expectation, output: Output) -> _Answer:
    box_by_frame = dict(zip(sign.frames, sign.boxes, strict=True))
    errors = {frame: output.error(frame, box_by_frame[frame]) for frame in expected.frames}
    worst = max(errors, key=lambda frame: errors[frame])
    wrong = [frame for frame, error in errors.items() if error > expectation.bounds.eq7]
    text = f"The largest Eq. 7 is {errors[worst]:.2f}, in frame {worst}."
    if wrong:
        off = "The box is off." if len(errors) == 1 else f"{len(wrong)} of {len(errors)} boxes are off."
        text = f"{off} {text}"
    return not wrong, text, worst


def _absent(expected: Expected, sign: ExpectedSign, expectation: Expectation, output: Output) -> _Answer:
    visible = sign.visible_boxes()
    track_by_frame = {
        frame: tracks[0] for frame, box in visible if (tracks := output.tracks_on(frame, box, expectation.bounds.iou))
    }
    if not track_by_frame:
        return True, "Nothing is tracked there.", sign.frames[0]
    first = min(track_by_frame)
    names = ", ".join(map(str, sorted(set(track_by_frame.values()))[:5]))
    return False, f"Track {names} lies there in {len(track_by_frame)} of {len(visible)} frames.", first


def _one(expected: Expected, sign: ExpectedSign, expectation: Expectation, output: Output) -> _Answer:
    counts = _tracks_on(sign, expectation.bounds, output)
    if len(counts) == 1:
        return True, f"Track {next(iter(counts))} lies on it.", sign.frames[0]
    if not counts:
        return False, "No track lies on it.", sign.frames[0]
    names = ", ".join(map(str, sorted(counts)[:8]))
    return False, f"{len(counts)} tracks lie on it: {names}.", _first_second_track(sign, expectation.bounds, output)


def _apart(expected: Expected, sign: ExpectedSign, expectation: Expectation, output: Output) -> _Answer:
    assert expected.other is not None
    other = expectation.signs[expected.other]
    both = sorted(
        _tracks_on(sign, expectation.bounds, output).keys() & _tracks_on(other, expectation.bounds, output).keys()
    )
    if not both:
        return True, "No track lies on both.", other.frames[0]
    return False, f"Track {', '.join(map(str, both[:8]))} lies on both.", other.frames[0]


_RULES = {"found": _found, "label": _label, "boxes": _boxes, "absent": _absent, "one": _one, "apart": _apart}


def _tracks_on(sign: ExpectedSign, bounds: Bounds, output: Output) -> Counter[int]:
    """Number of frames in which each track lies on a sign, without frames in which the sign is hidden."""
    counts: Counter[int] = Counter()
    for frame, box in sign.visible_boxes():
        counts.update(output.tracks_on(frame, box, bounds.iou))
    return counts


def _first_second_track(sign: ExpectedSign, bounds: Bounds, output: Output) -> int:
    """The first frame in which a second track lies on a sign."""
    known: set[int] = set()
    for frame, box in sign.visible_boxes():
        known.update(output.tracks_on(frame, box, bounds.iou))
        if len(known) > 1:
            return frame
    return sign.frames[0]


def _frames(frames: Sequence[int]) -> str:
    shown = ", ".join(map(str, frames[:6])) + (", ..." if len(frames) > 6 else "")
    return f"frame{'s' * (len(frames) > 1)} {shown}"
