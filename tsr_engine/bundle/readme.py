"""Writes ``README.txt``, which explains a bundle to a person who has never seen one."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from tsr_engine.bundle.judge import Finding
from tsr_engine.bundle.layout import NETWORK
from tsr_engine.bundle.manifest import Manifest
from tsr_engine.bundle.network import network_text

_WIDTH = 88


def readme_text(manifest: Manifest, findings: Sequence[Finding], warnings: Sequence[str]) -> str:
    """The text of ``README.txt``, by a manifest that need not have its ``files`` yet."""
    frames, run, network = manifest.frames, manifest.run, manifest.network
    options = "" if network is None else " --bundled-models" if network.inside else " --onnx FILE"
    last = frames.stop - 1
    parts = [
        _title("A bug report for tsr"),
        _text(
            "tsr finds, follows and names traffic signs in videos from a car. Somebody saw an error, and packed "
            "everything that is needed to see it on another machine."
        ),
        _title("What the reporter says"),
        _text(manifest.note or "(no note)"),
        _title("What is expected, and what came out"),
        *_findings(findings),
        _title("How to replay it"),
        _text("Install tsr, then run this in a terminal, with the name of this file:"),
        f"    tsr replay BUNDLE.zip{options}\n",
        *([] if network is None else [_text(network_text(network))]),
        _text(
            "The engine of your installation runs on the clip with the settings of the run, and its result is compared "
            "with what is expected. The last line says one of:"
        ),
        _items(
            "fixed (exit code 0): every expectation is met;",
            "still broken (exit code 20): an error of the report is still there;",
            "unchanged (exit code 20): nothing is expected, and the output is the reported one;",
            "different (exit code 21): the errors of the report are gone, but another expectation fails; or nothing "
            "is expected, and the output is another one.",
        ),
        _text(
            "--json prints all of it for a program, --set NAME=VALUE tries other settings, and --bundled-models uses "
            "the models in this bundle instead of yours, if there are any. In the tool (`tsr review`), 'Open bug "
            "bundle' in the library shows the clip, the output and the corrections."
        ),
        _title("What is inside"),
        _items(
            f"{manifest.clip.file}: the frames {manifest.clip.offset} to {last} of {manifest.video.name}; frame 0 of "
            f"the clip is frame {manifest.clip.offset} of the video. {manifest.clip.how} {_describe_lead_in(manifest)}",
            "frames.csv: for each of these frames its number in the clip, its time in the video in seconds, and the "
            "SHA-256 of the decoded picture.",
            f"output.csv: results of the engine in the frames {frames.first} to {last}, one row a track and frame. "
            "Boxes are x1, y1, x2, y2 in pixels from the upper left corner; score is the detector's.",
            "expectation.json: the expected results, for the replay.",
            "corrections.json: the corrected tracks as the tool stores them.",
            "evidence/: everything the engine decided in these frames, with the pixels that it used. "
            "`tsr replay evidence` (unpacked) repeats what follows the detector.",
            f"recording.rrd: {manifest.recording}",
            f"models/: {manifest.models}",
            *([f"{NETWORK}: the ONNX network that detected."] if network is not None and network.inside else []),
            "manifest.json: the origin of the bundle, all settings, and the SHA-256 of every file.",
        ),
        _text("Frames are numbered from 0, always as in the original video, not as in the clip."),
        _title("How it was made"),
        _items(
            f"Run {run.name or run.id or '(without a name)'} of {run.created or 'an unknown time'}, "
            f"engine {run.engine_version}, preset {run.preset or 'not known'}.",
            f"Video {manifest.video.name}, SHA-256 {manifest.video.sha256}, {manifest.video.size} bytes.",
            f"Packed by tsr {manifest.tool_version}.",
            *(f"{name}: {digest}" for name, digest in sorted(run.models.items())),
        ),
    ]
    if warnings:
        parts += [_title("Mind"), _items(*warnings)]
    return "\n".join(parts)


def _describe_lead_in(manifest: Manifest) -> str:
    frames = manifest.frames
    earlier = f" What comes before {frames.start} is there to be decoded from a key frame on."
    text = f"The engine works on the frames {frames.start} to {frames.stop - 1}."
    if manifest.clip.offset < frames.start:
        text += earlier
    if frames.start == frames.first:
        return text
    text += f" Those before {frames.first} only lead in, so that the engine knows what it knew in the run."
    if not frames.whole_lead_in:
        text += (
            f" That is not quite so here: signs that were in view before frame {frames.start} are found again, so "
            "numbers, votes and the first boxes may differ from the report."
        )
    return text


def _findings(findings: Sequence[Finding]) -> list[str]:
    if not findings:
        return [
            _text(
                "Nothing was corrected in these frames, so there is nothing to hold a replay against but the old "
                "output itself: read the note, and look at the recording."
            )
        ]
    shown = []
    for finding in findings:
        mark = "came true" if finding.met else "did not come true"
        shown.append(f"{finding.expected} That {mark}: {finding.got[:1].lower()}{finding.got[1:]}")
    return [_items(*shown)]


def _title(text: str) -> str:
    return f"{text}\n{'-' * len(text)}\n"


def _text(text: str) -> str:
    """Paragraphs, wrapped."""
    return "\n".join(textwrap.fill(line, _WIDTH) for line in text.splitlines()) + "\n"


def _items(*texts: str) -> str:
    return "\n".join(textwrap.fill(t, _WIDTH, initial_indent="* ", subsequent_indent="  ") for t in texts) + "\n"
