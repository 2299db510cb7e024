"""Makes a bundle: clip, evidence, output, expectation, recording, models and README in one ZIP file."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from tsr_engine.bundle.clip import Clip, cut_clip
from tsr_engine.bundle.evidence_slice import write_slice
from tsr_engine.bundle.judge import Finding, judge
from tsr_engine.bundle.layout import (
    CORRECTIONS,
    EVIDENCE,
    EXPECTATION,
    FRAMES,
    MANIFEST,
    MAX_FRAMES,
    MODELS,
    OUTPUT,
    README,
    RECORDING,
)
from tsr_engine.bundle.lead_in import LeadIn, find_lead_in
from tsr_engine.bundle.manifest import (
    BundleFile,
    BundleFrames,
    BundleRun,
    ClipFacts,
    Got,
    Manifest,
    NetworkFacts,
    SourceVideo,
)
from tsr_engine.bundle.models import ModelChoice, add_models, choose_models
from tsr_engine.bundle.network import add_network, network_text
from tsr_engine.bundle.output import Output, write_rows
from tsr_engine.bundle.readme import readme_text
from tsr_engine.bundle.request import BundleReport, BundleRequest
from tsr_engine.errors import EvidenceError, InputError, StorageError, TsrError, UsageError
from tsr_engine.evidence import EvidenceReader, ResultRow
from tsr_engine.exchange.archive import pack
from tsr_engine.exchange.publish import staging_folder
from tsr_engine.io.atomic import atomic_bytes, refuse_inputs, storage_error
from tsr_engine.io.digest import file_sha256
from tsr_engine.io.opened_file import display_path
from tsr_engine.io.video_probe import video_sha256
from tsr_engine.pipeline import ResultStream
from tsr_engine.recording import RecordingRequest, write_recording
from tsr_engine.records import FrameEvidence
from tsr_engine.version import __version__


def make_bundle(request: BundleRequest, progress: Callable[[int, int], None] = lambda _done, _of: None) -> BundleReport:
    """Make a bundle; the file appears complete or not at all.

    Equal requests give equal bytes, except for the recording.

    Args:
        request: the content.
        progress: called with (steps done, total); may raise to stop.

    Raises:
        EvidenceError: the run cannot be read, or the video is not the one that was tracked.
        UsageError: the frames are not in the run or too many, an expectation lies outside them, or the network is
            not that of the run.
        VideoError: the video cannot be read.
        StorageError: the file cannot be written.
    """
    refuse_inputs([request.out], [display_path(request.video)])
    if request.out.is_dir():
        raise StorageError(f"Cannot write {request.out}: it is a folder. Name a file.")
    try:
        with staging_folder(request.out) as folder, EvidenceReader(request.evidence) as reader:
            return _BundleBuilder(request, reader, folder, progress).build()
    except OSError as error:
        raise storage_error(request.out, error) from None


class _BundleBuilder:
    """The state of one call of ``make_bundle``."""

    def __init__(
        self, request: BundleRequest, reader: EvidenceReader, folder: Path, progress: Callable[[int, int], None]
    ) -> None:
        self.request, self.reader, self.folder = request, reader, folder
        self.lead_in = self._find_lead_in()
        self.count = request.stop - self.lead_in.start
        self.steps = 4 * self.count + 10
        self.progress = progress
        self.warnings: list[str] = []
        self.seconds: dict[int, float] = {}

    def build(self) -> BundleReport:
        request, folder, lead_in = self.request, self.folder, self.lead_in
        self._check_video()
        network = add_network(self.reader.header.models, request.network, folder)
        rows = self._evidence()
        clip = cut_clip(
            request.video,
            lead_in.start,
            request.stop,
            folder,
            table=request.table,
            limits=request.limits,
            progress=lambda done: self.progress(self.count + done, self.steps),
        )
        _write_frames(folder / FRAMES, clip, self.seconds)
        output = Output.from_rows(rows, request.first, request.stop)
        with (folder / OUTPUT).open("w", encoding="utf-8", newline="") as out:
            write_rows(out, output.rows)
        (folder / EXPECTATION).write_text(request.expectation.text(), encoding="utf-8", newline="")
        corrections = json.dumps({"format": 1, **request.corrections}, indent=1, sort_keys=True, ensure_ascii=False)
        (folder / CORRECTIONS).write_text(corrections + "\n", encoding="utf-8", newline="")
        models = choose_models(self.reader.header.models, request.models)
        if models.folder is not None:
            add_models(models.folder, folder / MODELS)
        self.progress(3 * self.count, self.steps)
        recording = self._recording()
        self.progress(4 * self.count, self.steps)
        findings = judge(request.expectation, output)
        self._warn(findings, output, models.folder is None and "not inside" in models.text, network)
        manifest = self._manifest(clip, models, network, recording, findings)
        (folder / README).write_text(readme_text(manifest, findings, self.warnings), encoding="utf-8", newline="")
        manifest = manifest.model_copy(update={"files": _files(folder)})
        (folder / MANIFEST).write_text(manifest.text(), encoding="utf-8", newline="")
        with atomic_bytes(request.out) as target:
            pack(folder, target, lambda: self.progress(4 * self.count + 5, self.steps))
        self.progress(self.steps, self.steps)
        size = request.out.stat().st_size
        return BundleReport(request.out, size, manifest, tuple(findings), tuple(self.warnings))

    def _find_lead_in(self) -> LeadIn:
        request = self.request
        last = self.reader.last_frame
        if request.stop <= request.first:
            raise UsageError(f"Frames {request.first}:{request.stop} are none. Expected A < B, counted from frame 0.")
        if last is not None and request.stop > last + 1:
            raise UsageError(f"The run ends with frame {last}. Got {request.first}:{request.stop}; end at {last + 1}.")
        found = find_lead_in(self.reader, request.first)
        if request.stop - found.start > MAX_FRAMES:
            raise UsageError(
                f"A bundle holds at most {MAX_FRAMES} frames, these are {request.stop - found.start} with the "
                f"{request.first - found.start} that lead in. Choose fewer."
            )
        span = request.expectation.span()
        if span is not None and not (request.first <= span[0] and span[1] < request.stop):
            raise UsageError(
                f"The expectation is about the frames {span[0]} to {span[1]}, the bundle has {request.first} to "
                f"{request.stop - 1}. Choose frames that hold them."
            )
        return found

    def _check_video(self) -> None:
        known = self.reader.header.video
        if not display_path(self.request.video).is_file():
            raise InputError(f"There is no video at {self.request.video}. Give its present path.")
        if video_sha256(self.request.video) != known.sha256:
            raise EvidenceError(
                f"{self.request.video} is not the video of the run in {self.reader.folder}: that was {known.name} "
                f"with the SHA-256 {known.sha256[:12]}... . Name that file."
            )

    def _evidence(self) -> list[ResultRow]:
        """Store the evidence of the range; return its result rows."""
        stream = ResultStream()
        rows: list[ResultRow] = []

        def on_frame(frame: FrameEvidence) -> None:
            rows.extend(stream.add(frame))
            self.seconds[frame.ordinal] = frame.seconds
            self.progress(len(self.seconds), self.steps)

        write_slice(
            self.reader,
            self.folder / EVIDENCE,
            self.lead_in.start,
            self.request.stop,
            self.reader.header,
            on_frame=on_frame,
        )
        rows.extend(stream.finish())
        return rows

    def _recording(self) -> str:
        """Make the recording; return a sentence about it."""
        request = self.request
        if not request.recording:
            return "not asked for."
        try:
            write_recording(
                RecordingRequest(
                    request.evidence,
                    self.folder / RECORDING,
                    request.first,
                    request.stop,
                    request.video,
                    request.table,
                    corrected=request.corrected,
                    classes=request.classes,
                    limits=request.limits,
                )
            )
        except (TsrError, ImportError) as error:
            (self.folder / RECORDING).unlink(missing_ok=True)
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            return f"could not be made ({reason.rstrip('.')})."
        return "everything drawn over the clip, for the Rerun viewer (`rerun recording.rrd`, or in the tool)."

    def _warn(
        self, findings: Sequence[Finding], output: Output, models_missing: bool, network: NetworkFacts | None
    ) -> None:
        if findings and all(finding.met for finding in findings):
            self.warnings.append(
                "The run's own output meets every expectation in these frames, so a replay would say 'fixed' at once."
            )
        continuing = [t for t in self.reader.tracks(self.request.stop, None) if t.first_frame < self.request.stop]
        continuing = [t for t in continuing if t.track_id in set(output.tracks)]
        if continuing:
            names = ", ".join(f"{t.track_id} (to frame {t.last_frame})" for t in continuing[:5])
            self.warnings.append(
                f"Tracks that continue after the last frame are judged as they are there: {names}. Their class is only "
                "expected if somebody has corrected it."
            )
        if not self.lead_in.is_exact:
            self.warnings.append(
                f"Tracks were in view all the way back, so the engine starts at frame {self.lead_in.start} without "
                "them."
            )
        if models_missing:
            self.warnings.append("The models of the run are not inside: a replay uses those of the installation.")
        if network is not None and not network.inside:
            self.warnings.append(network_text(network))

    def _manifest(
        self,
        clip: Clip,
        models: ModelChoice,
        network: NetworkFacts | None,
        recording: str,
        findings: Sequence[Finding],
    ) -> Manifest:
        request, header = self.request, self.reader.header
        table = header.frame_table
        try:
            interval, width, height = float(table["interval"]), int(table["width"]), int(table["height"])
        except (KeyError, TypeError, ValueError):
            raise EvidenceError(
                f"{self.reader.folder} does not say the size and rate of its video. Track it again."
            ) from None
        return Manifest(
            tool_version=__version__,
            note=request.note,
            tracks=list(request.tracks),
            frames=BundleFrames(
                start=self.lead_in.start,
                first=request.first,
                stop=request.stop,
                whole_lead_in=self.lead_in.is_exact,
                first_id=self.lead_in.first_id,
            ),
            clip=ClipFacts(
                file="clip.mp4" if clip.path.suffix == ".mp4" else "clip.mkv",
                sha256=file_sha256(clip.path),
                offset=clip.offset,
                width=width,
                height=height,
                copied=clip.copied,
                how=clip.how,
            ),
            video=SourceVideo(name=header.video.name, sha256=header.video.sha256, size=header.video.size),
            run=BundleRun(
                id=request.run_id,
                name=request.run_name,
                kind="whatif" if request.kind == "whatif" else "engine",
                preset=request.preset,
                created=header.created,
                engine_version=header.engine_version,
                parameters=dict(header.parameters),
                models=dict(header.models),
                interval=interval,
            ),
            models=models.text,
            models_inside=models.folder is not None,
            network=network,
            recording=recording,
            got=[Got(id=finding.id, met=finding.met, text=finding.got) for finding in findings],
            files=[],
        )


def _write_frames(path: Path, clip: Clip, seconds: Mapping[int, float]) -> None:
    """Write the frames with the times that the engine got: an imported clip has other times."""
    with path.open("w", encoding="utf-8", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["frame", "clip_frame", "seconds", "picture_sha256"])
        writer.writerows((f.ordinal, f.clip, repr(seconds[f.ordinal]), f.digest) for f in clip.frames)


def _files(folder: Path) -> list[BundleFile]:
    """Every file but the manifest, sorted by name."""
    return [
        BundleFile(name=path.relative_to(folder).as_posix(), size=path.stat().st_size, sha256=file_sha256(path))
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    ]
