"""``tsr record``: frames of a run as a file for the Rerun viewer."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.library import HomeOption
from tsr_engine.cli.common import JsonOption, existing, frame_range, out_console, print_json, say
from tsr_engine.errors import UsageError
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from app.exchange.dataset import Source
    from tsr_engine.recording import BoxRows


def record(
    name: Annotated[
        str, typer.Argument(metavar="RUN", help="A run's id, an evidence folder, or a video (its newest run).")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.rrd", help="The file to write.")],
    frames: Annotated[
        str | None, typer.Option("--frames", metavar="A:B", help="Only frames A to B-1; unset: all of the run.")
    ] = None,
    home: HomeOption = None,
    video: Annotated[
        Path | None, typer.Option("--video", metavar="FILE", help="The video of a bare evidence folder.")
    ] = None,
    picture: Annotated[bool, typer.Option("--picture/--no-picture", help="Include the picture.")] = True,
    exact: Annotated[bool, typer.Option("--exact", help="Copy the video's own packets at any size.")] = False,
    frame: Annotated[
        int | None, typer.Option("--at", metavar="FRAME", min=0, help="Frame to mark on the time panel.")
    ] = None,
    track: Annotated[str | None, typer.Option("--track", metavar="N", help="Track whose lines come first.")] = None,
    json: JsonOption = False,
) -> None:
    """Write a recording of frames for the Rerun viewer: picture, boxes, gate, votes and events.

    Corrections and ground truth of the data folder are included. Open it with 'rerun FILE.rrd'.

    \b
    Examples:
      tsr record run1 --video drive.mp4 --frames 100:400 --out drive.rrd
      tsr record drive.mp4 --frames 100:400 --out drive.rrd --at 212 --track 7
    """
    if out.suffix.lower() != ".rrd":
        raise UsageError(f"--out must end with .rrd, because viewers check the extension. Got '{out}'.")
    first, stop = frame_range(frames)
    from app.cli.progress import step_counter
    from app.cli.run_names import find_sources
    from tsr_engine.io.atomic import refuse_inputs
    from tsr_engine.io.opened_file import display_path
    from tsr_engine.recording import RecordingRequest, write_recording

    source = find_sources([name], home, None if video is None else existing(video, "video"), say)[0]
    refuse_inputs(
        [out], [display_path(p) for p in (source.video.path, source.folder / "evidence.sqlite") if p is not None]
    )
    focus = _focus(source, first, stop, frame, track)
    corrected, truth = _annotated(source)
    request = RecordingRequest(
        evidence=source.folder,
        out=out,
        first=None if frames is None else first,
        stop=stop,
        video=source.video.path if picture else None,
        limits=source.video.limits,
        known=video is not None,  # checked when the run was named
        exact=exact,
        corrected=corrected,
        truth=truth,
        classes=source.classes,
        focus_frame=frame,
        focus_track=focus,
        called=source.display_name,
    )
    with step_counter("recording") as progress:
        report = write_recording(request, progress)
    if picture and source.video.path is None:
        say("warning: the video is missing, so the recording has no picture. Name it with --video.")
    if json:
        from app.recordings.summary import report_summary

        print_json({"out": str(out), "run": source.run_id, "size": report.size, **report_summary(report)})
        return
    console = out_console()
    console.print(
        f"{out}: frames {report.first} to {report.stop - 1}, {plural(sum(report.boxes.values()), 'box', 'boxes')} in "
        f"{plural(len(report.boxes), 'layer')}, {plural(len(report.tracks), 'track')}, {report.size / 1e6:.1f} MB "
        f"in {report.seconds:.1f} s.",
        soft_wrap=True,
    )
    console.print(f"Picture: {report.picture}", soft_wrap=True, markup=False)


def _focus(source: Source, first: int, stop: int | None, frame: int | None, track: str | None) -> int | None:
    """The number of the track to select first.

    Raises:
        UsageError: the run has no such track, or the frame is not recorded.
    """
    from app.cli.run_names import track_key
    from tsr_engine.evidence import EvidenceReader

    low, behind = max(first, source.first), source.stop if stop is None else stop
    is_stored = low < behind <= source.stop  # the recording refuses other ranges
    if frame is not None and is_stored and not low <= frame < behind:
        raise UsageError(f"--at must be one of the recorded frames, {low} to {behind - 1}. Got {frame}.")
    if track is None:
        return None
    key = track_key(track)
    with EvidenceReader(source.folder) as reader:
        known = {f"m{one.track_id}": one.track_id for one in reader.tracks() if one.confirmed}
    if key not in known:
        raise UsageError(f"--track must be the number of one of the run's {len(known)} tracks. Got '{track}'.")
    return known[key]


def _annotated(source: Source) -> tuple[BoxRows | None, BoxRows | None]:
    """Corrections and ground truth of a run of a data folder; a bare evidence folder has none."""
    if source.run_id is None:
        return None, None
    from app.cli.data_folder import open_home
    from app.recordings.annotation import corrected_rows, truth_of

    with open_home(source.folder.parents[1]) as (_, database), database.read() as session:
        truth = truth_of(session, source.video.sha256, None, source.classes.labels)
    return corrected_rows(source.folder, source.documents, source.classes), truth
