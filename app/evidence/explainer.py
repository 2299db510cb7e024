"""Computes verdicts again in a separate process, because the engine's compiled code would double the server's memory.

The process starts with the first question, answers one at a time as lines of JSON, and ends after some idle time.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from app.evidence.crops import pixels_in_frame
from app.evidence.explain import Explanation, explain
from app.sandbox.confine import restrict_process
from app.videos.checked_file import CheckedFile
from tsr_engine.errors import EvidenceError, TsrError
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.regions import FramePixels
from tsr_engine.io.video import open_video
from tsr_engine.io.video_limits import MAX_PIXELS, VideoLimits
from tsr_engine.json_shapes import JsonObject
from tsr_engine.protocols import PixelSource

IDLE_TIMEOUT_S = 60.0
"""Idle seconds after which the process ends."""
ANSWER_TIMEOUT_S = 60.0
"""Seconds to wait for an answer."""


@dataclass(frozen=True, slots=True)
class ExplainRequest:
    """One verdict.

    Attributes:
        folder: evidence of the run.
        pixels: evidence with the pixels; for a what-if, that of the run that it replays.
        video: file to decode frames without stored pixels from; empty: there is none.
        sha256: hash of that file.
        stamp: state of the file when its bytes were last compared with the hash; None: never.
        roots: folders in which links in its path are followed.
        track: number of the engine's track.
        frame: ordinal.
        max_pixels: largest picture that the file may have.
    """

    folder: str
    pixels: str
    video: str
    track: int
    frame: int
    max_pixels: int = MAX_PIXELS
    sha256: str = ""
    stamp: tuple[int, int, int, int] | None = None
    roots: tuple[str, ...] = ()

    def source(self) -> CheckedFile:
        """The file."""
        stamp = None if self.stamp is None else tuple(self.stamp)
        return CheckedFile(Path(self.video), [Path(root) for root in self.roots], self.sha256, stamp)  # type: ignore[arg-type]


class Explainer:
    """Sends questions to the process; thread-safe."""

    def __init__(self, idle: float = IDLE_TIMEOUT_S) -> None:
        self._idle = idle
        self._lock = threading.Lock()
        self.process: subprocess.Popen[str] | None = None
        self._timer: threading.Timer | None = None

    def explain(self, request: ExplainRequest) -> Explanation | None:
        """Answer a question; None: the gate did not judge that prediction.

        Raises:
            EvidenceError: the evidence is damaged or incomplete, or the process died twice.
        """
        with self._lock:
            line = self._request(request) or self._request(request)  # again if the process has died
            self._restart_idle_timer()
        if not line:
            raise EvidenceError("The verdict could not be computed: its process ended. Try again.")
        answer = json.loads(line)
        if "error" in answer:
            raise EvidenceError(answer["error"])
        return None if answer["explanation"] is None else Explanation.model_validate(answer["explanation"])

    def close(self) -> None:
        """End the process."""
        with self._lock:
            if self._timer is not None:
                self._timer.cancel()
            self._stop()

    def _request(self, request: ExplainRequest) -> str:
        process = self.process
        if process is None or process.poll() is not None:
            self._stop()
            process = self.process = subprocess.Popen(
                [sys.executable, "-m", "app.evidence.explainer"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                encoding="utf-8",
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )
        assert process.stdin is not None
        assert process.stdout is not None
        timeout = threading.Timer(ANSWER_TIMEOUT_S, process.kill)
        timeout.daemon = True
        timeout.start()
        try:
            process.stdin.write(json.dumps(asdict(request)) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except OSError:
            line = ""
        finally:
            timeout.cancel()
        if not line:
            self._stop()  # a process that has just died may still look alive
        return line

    def _restart_idle_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = threading.Timer(self._idle, self.close)
        self._timer.daemon = True
        self._timer.start()

    def _stop(self) -> None:
        process, self.process = self.process, None
        if process is None:
            return
        process.kill()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        process.wait()


def main() -> None:
    """Answer questions until the input ends; confined, because the videos that it decodes may be malicious."""
    restrict_process(None)
    for line in sys.stdin:
        signal.alarm(int(ANSWER_TIMEOUT_S) + 1)  # the server may have ended by then
        request = ExplainRequest(**json.loads(line))
        try:
            explanation = explain_request(request)
            answer: JsonObject = {"explanation": None if explanation is None else explanation.model_dump(mode="json")}
        except TsrError as error:
            answer = {"error": str(error)}
        print(json.dumps(answer), flush=True)
        signal.alarm(0)


def explain_request(request: ExplainRequest) -> Explanation | None:
    """Compute a verdict again in this process; see :meth:`Explainer.explain`."""
    with EvidenceReader(Path(request.folder)) as reader, EvidenceReader(Path(request.pixels)) as source:

        def pixels(frame: int) -> PixelSource:
            stored = pixels_in_frame(source, frame)
            if stored is not None:
                return stored
            if not request.video:
                raise EvidenceError("The run has no stored pixels and its video is missing. Put the video back.")
            with open_video(request.source(), limits=VideoLimits(request.max_pixels)) as video:
                return FramePixels(video.read(frame).picture)

        return explain(reader, request.track, request.frame, pixels)


if __name__ == "__main__":
    main()
