"""Exports over an older export, killed or failing at each step in turn; prints what is left.

Run as a script in a separate process, since it forks: ``python export_killer.py FOLDER``.
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

from tests.exchange.small_datasets import make_dataset, make_track
from tsr_engine.errors import StorageError
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.export import export_dataset
from tsr_engine.exchange.registry import FORMATS
from tsr_engine.io.unfinished import remove_leftovers

OLD, NEW = make_dataset(make_track("old")), make_dataset(make_track("new"), make_track("other", range(50, 60)))
STEPS = frozenset(
    {"open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "fcntl.flock", "shutil.rmtree", "os.listdir"}
)


def state(out: Path) -> str:
    """Hash of the content below a path."""
    digest = hashlib.sha256()
    for path in sorted([out, *out.rglob("*")]):
        digest.update(path.name.encode() + (path.read_bytes() if path.is_file() else b"/"))
    return digest.hexdigest()


def act_at_step(folder: Path, at: int, act: Callable[[], None]) -> None:
    """Call ``act`` at the step with this number; steps open, create, rename, remove, lock or sync files."""
    count = 0

    def step() -> None:
        nonlocal count
        count += 1
        if count == at:
            act()

    def hook(event: str, args: tuple[object, ...]) -> None:
        if event == "open" and isinstance(args[0], str | bytes) and str(folder) not in os.fsdecode(args[0]):
            return
        if event in STEPS or event == "ctypes.dlsym":
            step()

    os.fsync = lambda _: step()
    sys.addaudithook(hook)


def child(folder: Path, zipped: bool, at: int, mode: str) -> int:
    """Exit code of an export in a child process: 0 success, -9 killed, 7 failed with a sentence, 1 other errors."""
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    code = 1
    try:
        armed = True

        def act() -> None:
            nonlocal armed
            if mode == "kill":
                os.kill(os.getpid(), signal.SIGKILL)
            if armed:
                armed = False
                raise OSError(28, "No space left on device")

        act_at_step(folder, at, act)
        export_dataset(NEW, FORMATS["cvat-video"], folder / "out", zipped=zipped)
        code = 0
    except StorageError:
        code = 7
    finally:
        os._exit(code)


def interrupt_each_step(folder: Path, zipped: bool, mode: str) -> dict[str, object]:
    """Act at every step in turn, until an export completes all steps."""
    out = folder / "out"

    def write(data: Dataset) -> str:
        export_dataset(data, FORMATS["cvat-video"], out, zipped=zipped)
        return state(out)

    new, old = write(NEW), write(OLD)
    codes: list[int] = []
    kept = replaced = rubbish = 0
    while codes[-1:] != [0] if mode == "kill" else codes[-5:] != [0] * 5:
        codes.append(child(folder, zipped, len(codes) + 1, mode))
        found = state(out)
        if found not in (old, new):
            sys.exit(f"step {len(codes)}: what stands there is neither the old nor the new export")
        kept, replaced = kept + (found == old), replaced + (found == new)
        left = len(list(folder.iterdir())) > 1
        rubbish += left
        # The next export begins with this state; run one every fourth time, and where required.
        remove_leftovers(out)
        if found == new or (left and rubbish % 4 == 0):
            write(OLD)
        if state(out) != old or [path.name for path in folder.iterdir()] != ["out"]:
            sys.exit(f"step {len(codes)}: the next export left {sorted(path.name for path in folder.iterdir())}")
    return {"old": kept, "new": replaced, "rubbish": rubbish, "codes": codes}


def kill_at_moments(folder: Path, zipped: bool, count: int = 6) -> dict[str, int]:
    """Kill exports at times spread over their duration."""
    out = folder / "out"
    big = make_dataset(*(make_track(f"m{k}", range(k, k + 30)) for k in range(30)))
    began = time.monotonic()
    export_dataset(big, FORMATS["yolo"], out, zipped=zipped)
    took, killed = time.monotonic() - began, 0
    new = state(out)
    export_dataset(OLD, FORMATS["yolo"], out, zipped=zipped)
    old = state(out)
    for turn in range(count + 1):
        began = time.monotonic()
        pid = os.fork()
        if not pid:
            export_dataset(big, FORMATS["yolo"], out, zipped=zipped)
            os._exit(0)
        if turn:  # the first one and the one above show the shortest duration
            time.sleep(took * (turn - 0.5) / count)
            os.kill(pid, signal.SIGKILL)
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        if not turn:
            took = min(took, time.monotonic() - began)
        elif code == 0:  # too late: the machine was busy during the measurement
            took /= 2
        killed += code == -signal.SIGKILL
        if state(out) != (new if code == 0 else old) and (code == 0 or state(out) != new):
            sys.exit(f"moment {turn}: what stands there is neither the old nor the new export")
        remove_leftovers(out)
        if [path.name for path in folder.iterdir()] != ["out"]:
            sys.exit(f"moment {turn}: left {sorted(path.name for path in folder.iterdir())}")
        if state(out) == new:
            export_dataset(OLD, FORMATS["yolo"], out, zipped=zipped)
    return {"killed": killed, "moments": count}


def main() -> None:
    """Print a report for folders and ZIP files, killed at each step, failing at each step, and killed at any moment."""
    os.fsync = lambda _: None  # a killed process keeps what it has written
    reports: dict[str, object] = {}
    for kind in ("folder", "zip"):
        folder = Path(sys.argv[1]) / f"{kind}-moments"
        folder.mkdir()
        reports[f"{kind}-moments"] = kill_at_moments(folder, kind == "zip")
        for mode in ("kill", "fail"):
            folder = Path(sys.argv[1]) / f"{kind}-{mode}"
            folder.mkdir()
            reports[f"{kind}-{mode}"] = interrupt_each_step(folder, kind == "zip", mode)
    print(json.dumps(reports))


if __name__ == "__main__":
    main()
