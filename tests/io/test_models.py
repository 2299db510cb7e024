"""A model folder keeps its old content until the new content is complete, whatever happens in between."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsr_engine.errors import ModelError, StorageError
from tsr_engine.io.models import (
    MANIFEST,
    SHIPPED,
    Component,
    component_path,
    load_component,
    read_manifest,
    save_component,
)


def make_component(value: float, name: str = "prior", **more: Any) -> Component:
    return Component(name, {"table": np.full((4, 4), value)}, {"lambda": 0.5}, seed=3, **more)


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_named_by_its_hash_and_the_older_one_is_removed(tmp_path: Path) -> None:
    online = save_component(make_component(9, "online"), tmp_path)
    for value in (1.0, 2.0):
        digest = save_component(make_component(value, figures={"error": 0.1 * value}), tmp_path)
        assert component_path("prior", tmp_path) == tmp_path / f"prior-{digest[:12]}.npz"
        assert files(tmp_path) == [MANIFEST, f"online-{online[:12]}.npz", f"prior-{digest[:12]}.npz"]
        back = load_component("prior", tmp_path)
        assert (back.sha256, back.seed, back.figures) == (digest, 3, {"error": 0.1 * value})
        np.testing.assert_array_equal(back.arrays["table"], np.full((4, 4), value))
    assert save_component(make_component(2.0), tmp_path) == digest, "the same arrays give the same file"
    assert load_component("online", tmp_path).sha256 == online


def test_folders_with_other_file_names(tmp_path: Path) -> None:
    """Like those of the package: they load, and are removed when the manifest names another file."""
    folder = tmp_path / "models"
    shutil.copytree(SHIPPED, folder)
    before = read_manifest(folder)["components"]
    assert load_component("prior", folder).sha256 == before["prior"]["sha256"]
    (folder / "prior-notes.npz").write_bytes(b"somebody else's")
    save_component(make_component(1.0), folder)
    expected = {entry["file"] for name, entry in before.items() if name != "prior"}
    assert set(files(folder)) == expected | {MANIFEST, "prior-notes.npz", component_path("prior", folder).name}
    np.testing.assert_array_equal(load_component("prior", folder).arrays["table"], np.ones((4, 4)))
    for name in set(before) - {"prior"}:
        assert load_component(name, folder).sha256 == before[name]["sha256"]


@pytest.mark.parametrize("part", ["params", "data", "figures"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_not_finite_is_refused_before_writing(tmp_path: Path, part: str, value: float) -> None:
    save_component(make_component(1.0), tmp_path)
    there = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    bad = Component("prior", {"table": np.zeros(3)}, **{part: {"sizes": [{"ap": 0.5}, {"ap": value}]}})
    with pytest.raises(ModelError, match=rf"component 'prior'\. Got {value} for {part}\.sizes\.1\.ap: "):
        save_component(bad, tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == there
    assert load_component("prior", tmp_path).arrays["table"][0, 0] == 1.0


def test_an_unreadable_manifest_is_kept(tmp_path: Path) -> None:
    (tmp_path / MANIFEST).write_text(json.dumps({"format": 99, "components": {}}))
    with pytest.raises(ModelError, match="format 99"):
        save_component(make_component(1.0), tmp_path)
    assert files(tmp_path) == [MANIFEST]


def test_a_manifest_that_is_nested_too_deeply(tmp_path: Path) -> None:
    (tmp_path / MANIFEST).write_text("[" * 100_000)
    with pytest.raises(ModelError, match="Cannot read"):
        read_manifest(tmp_path)


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(StorageError, match="a file stands where a folder is needed"):
        save_component(make_component(1.0), tmp_path / "file")


def test_killed_at_any_step_the_old_component_or_the_new_one_loads(tmp_path: Path) -> None:
    """A child is killed at each file that it opens, syncs, renames or removes, in turn."""
    script = """
import json, os, signal, sys
from pathlib import Path
import numpy as np
from tsr_engine.io.models import Component, load_component, save_component

folder = Path(sys.argv[1])
def save(value):
    save_component(Component("prior", {"table": np.full(4, value)}), folder)
def child(at):
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    count = 0
    def step(event, args):
        nonlocal count
        if event == "open" and str(folder) not in str(args[0]):
            return
        if event in ("open", "os.rename", "os.remove", "fsync"):
            count += 1
            if count == at:
                os.kill(os.getpid(), signal.SIGKILL)
    os.fsync = lambda _: step("fsync", ())
    sys.addaudithook(step)
    save(2.0)
    os._exit(0)
found, left, code = [], [], -1
while code:
    save(1.0)
    left.append(len(list(folder.iterdir())))
    code = child(len(found) + 1)
    found.append(float(load_component("prior", folder).arrays["table"][0]))
print(json.dumps([found, left]))
"""
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "m")], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    found, left = json.loads(done.stdout)
    assert found == sorted(found), "from some step on the new one"
    assert found.count(1.0) >= 8
    assert found.count(2.0) >= 3
    assert set(left) == {2}, "what the killed ones left goes with the next"
