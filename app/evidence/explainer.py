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

from app.cages.confine import stay_in
from app.evidence.crops import pixels_in_frame
from app.evidence.explain import Explanation, explain
from app.videos.opened import CheckedFile
from tsr_engine.errors import EvidenceError, TsrError
from tsr_engine.evidence.reader import EvidenceReader
from tsr_engine.evidence.regions import FramePixels
from tsr_engine.io.video import open_video
from tsr_engine.io.video_limits import MAX_PIXELS, VideoLimits
from tsr_engine.json_shapes import JsonObject
from tsr_engine.protocols import PixelSource

__all__ = ["Explainer", "Question", "explain_question"]

IDLE = 60.0
"""Idle seconds after which the process ends."""
PATIENCE = 60.0
"""Seconds to wait for an answer."""


@dataclass(frozen=True, slots=True)
class Question:
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

    def __init__(self, idle: float = IDLE) -> None:
        self._idle = idle
        self._lock = threading.Lock()
        self.process: subprocess.Popen[str] | None = None
        self._timer: threading.Timer | None = None

    def ask(self, question: Question) -> Explanation | None:
        """Answer a question; None: the gate did not judge that prediction.

        Raises:
            EvidenceError: the evidence is damaged or incomplete, or the process died twice.
        """
        with self._lock:
            line = self._answer(question) or self._answer(question)  # again if the process has died
            self._rest()
        if not line:
            raise EvidenceError("The verdict could not be computed: its process ended. Try again.")
        answer = json.loads(line)
        if "error" in answer:
            raise EvidenceError(answer["error"])
        return None if answer["found"] is None else Explanation.model_validate(answer["found"])

    def close(self) -> None:
        """End the process."""
        with self._lock:
            if self._timer is not None:
                self._timer.cancel()
            self._stop()

    def _answer(self, question: Question) -> str:
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
        overdue = threading.Timer(PATIENCE, process.kill)
        overdue.daemon = True
        overdue.start()
        try:
            process.stdin.write(json.dumps(asdict(question)) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except OSError:
            line = ""
        finally:
            overdue.cancel()
        if not line:
            self._stop()  # a process that has just died may still look alive
        return line

    def _rest(self) -> None:
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
    stay_in(None)
    for line in sys.stdin:
        signal.alarm(int(PATIENCE) + 1)  # the server may have ended by then
        question = Question(**json.loads(line))
        try:
            found = explain_question(question)
            answer: JsonObject = {"found": None if found is None else found.model_dump(mode="json")}
        except TsrError as error:
            answer = {"error": str(error)}
        print(json.dumps(answer), flush=True)
        signal.alarm(0)


def explain_question(question: Question) -> Explanation | None:
    """Compute a verdict again in this process; see :meth:`Explainer.ask`."""
    with EvidenceReader(Path(question.folder)) as reader, EvidenceReader(Path(question.pixels)) as source:

        def pixels(frame: int) -> PixelSource:
            stored = pixels_in_frame(source, frame)
            if stored is not None:
                return stored
            if not question.video:
                raise EvidenceError("The run has no stored pixels and its video is missing. Put the video back.")
            with open_video(question.source(), limits=VideoLimits(question.max_pixels)) as video:
                return FramePixels(video.read(frame).picture)

        return explain(reader, question.track, question.frame, pixels)


if __name__ == "__main__":
    main()
