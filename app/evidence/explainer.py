"""Computes verdicts again in a process of its own: the engine's compiled code would double the server's memory.

It starts with the first question, answers one at a time as lines of JSON, and ends when nobody has asked for a while.
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
from tsr_engine.io.video_limits import MOST_PIXELS, VideoLimits
from tsr_engine.json_shapes import JsonObject
from tsr_engine.protocols import PixelSource

__all__ = ["Explainer", "Question", "explain_question"]

IDLE = 60.0
"""Seconds without a question after which the process ends."""
PATIENCE = 60.0
"""Seconds after which an answer is given up."""


@dataclass(frozen=True, slots=True)
class Question:
    """One verdict.

    Attributes:
        folder: evidence of the run.
        pixels: evidence that holds the pixels; that of the run that a what-if replays.
        video: the file that frames without stored pixels are decoded from; empty: there is none.
        sha256: of that file.
        stamp: how it stood when its bytes were last compared with that; None: never.
        roots: folders in which links on the way to it are followed.
        track: number of the engine's track.
        frame: ordinal.
        max_pixels: largest picture that the file may have.
    """

    folder: str
    pixels: str
    video: str
    track: int
    frame: int
    max_pixels: int = MOST_PIXELS
    sha256: str = ""
    stamp: tuple[int, int, int, int] | None = None
    roots: tuple[str, ...] = ()

    def source(self) -> CheckedFile:
        """The file."""
        stamp = None if self.stamp is None else tuple(self.stamp)
        return CheckedFile(Path(self.video), [Path(root) for root in self.roots], self.sha256, stamp)  # type: ignore[arg-type]


class Explainer:
    """Asks the process; thread-safe."""

    def __init__(self, idle: float = IDLE) -> None:
        self._idle = idle
        self._lock = threading.Lock()
        self.process: subprocess.Popen[str] | None = None
        self._timer: threading.Timer | None = None

    def ask(self, question: Question) -> Explanation | None:
        """The answer; None: the gate did not judge that prediction.

        Raises:
            EvidenceError: the evidence is damaged or lacks what is needed.
        """
        with self._lock:
            line = self._answer(question) or self._answer(question)  # a second time, should the first process have died
            self._rest()
        if not line:
            raise EvidenceError("The verdict could not be judged again: the process that does it ended. Try once more.")
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
            self._stop()  # one that has just died may still look alive
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
    """Answer questions until the input ends; a video that is decoded for one may be hostile."""
    stay_in(None)
    for line in sys.stdin:
        signal.alarm(int(PATIENCE) + 1)  # the server may be gone by then
        question = Question(**json.loads(line))
        try:
            found = explain_question(question)
            answer: JsonObject = {"found": None if found is None else found.model_dump(mode="json")}
        except TsrError as error:
            answer = {"error": str(error)}
        print(json.dumps(answer), flush=True)
        signal.alarm(0)


def explain_question(question: Question) -> Explanation | None:
    """Judge a prediction again in this process; see :meth:`Explainer.ask`."""
    with EvidenceReader(Path(question.folder)) as reader, EvidenceReader(Path(question.pixels)) as source:

        def pixels(frame: int) -> PixelSource:
            stored = pixels_in_frame(source, frame)
            if stored is not None:
                return stored
            if not question.video:
                raise EvidenceError("The run keeps no pixels and its video is not there any more. Put the video back.")
            with open_video(question.source(), limits=VideoLimits(question.max_pixels)) as video:
                return FramePixels(video.read(frame).picture)

        return explain(reader, question.track, question.frame, pixels)


if __name__ == "__main__":
    main()
