"""``tsr replay BUNDLE``: what it prints, and the exit codes; models inside a bundle."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests import toy_pipeline
from tests.bundle.tracked_drive import TrackedDrive, make_expectation
from tsr_engine.bundle.models import add_models, choose_models, extract_models
from tsr_engine.cli.main import run
from tsr_engine.errors import ImportFormatError
from tsr_engine.io.models import SHIPPED, Component, load_component, read_manifest, save_component


@pytest.fixture
def toy_parts(drive: TrackedDrive, monkeypatch: pytest.MonkeyPatch) -> None:
    """Toy parts in place of trained models."""
    monkeypatch.setattr("tsr_engine.pipeline.load_components", toy_pipeline.load_components)


@pytest.mark.usefixtures("toy_parts")
def test_exit_codes_and_report(drive: TrackedDrive, tmp_path: Path, capfd: Any) -> None:
    frames = list(range(48, 60))
    signs = {"h1": {"frames": frames, "boxes": [toy_pipeline.sign_box(k % 40).tolist() for k in frames]}}
    expected = [{"id": kind, "kind": kind, "sign": "h1"} for kind in ("absent", "found")]
    path = drive.bundle(tmp_path / "bug.zip", expectation=make_expectation(signs=signs, expected=expected)).path
    assert run(["replay", str(path)]) == 20
    text = capfd.readouterr().out
    assert (
        "STILL BROKEN: Nothing is tracked where the box marked in frame 48 lies (frames 48 to 59): there is no sign."
        in text
    )
    assert "All 24 frames are bit by bit those of the run." in text
    assert "frames 46 to 69 of drive.mp4, 67 frames run (43 of them to lead in) in " in text
    assert text.strip().splitlines()[-1] == "still broken"
    rows = tmp_path / "rows.csv"
    assert run(["replay", str(path), "--set", "birth_score=50", "--json", "--csv", str(rows)]) == 21
    reported = json.loads(capfd.readouterr().out)
    assert (reported["verdict"], reported["exit_code"], reported["tracks"]) == ("different", 21, 0)
    assert [one["verdict"] for one in reported["expected"]] == ["fixed", "newly broken"]
    assert any("birth_score" in sentence for sentence in reported["changed"])
    assert rows.read_text().count("\n") == 1
    only = make_expectation(signs=signs, expected=expected[1:])
    path = drive.bundle(tmp_path / "right.zip", expectation=only).path
    assert run(["replay", str(path)]) == 0
    assert capfd.readouterr().out.strip().splitlines()[-1] == "fixed"


@pytest.mark.usefixtures("toy_parts")
def test_the_same_output_without_expectations_is_not_fixed(plain: Path, capfd: Any) -> None:
    assert run(["replay", str(plain)]) == 20
    text = capfd.readouterr().out
    assert "The bundle has no expectations" in text
    assert text.strip().splitlines()[-1] == "unchanged"


@pytest.mark.usefixtures("toy_parts")
def test_wrong_options_are_refused(drive: TrackedDrive, plain: Path, capfd: Any) -> None:
    for arguments, words in (
        (["replay", str(plain), "--set", "nope=1"], "no parameter 'nope'"),
        (["replay", str(plain), "--models", "x", "--bundled-models"], "Choose one of them"),
        (["replay", str(drive.run), "--bundled-models"], "is for a bug bundle"),
    ):
        assert run(arguments) == 2
        assert words in capfd.readouterr().err
    assert run(["replay", str(plain), "--bundled-models"]) == 3
    assert "holds no models" in capfd.readouterr().err


@pytest.mark.usefixtures("toy_parts")
def test_a_focus_that_a_run_has_not_estimated_must_be_named(
    plain: Path, capfd: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    paper = toy_pipeline.PARAMS.with_settings([("motion", "paper"), ("coast_foe_y", None)])
    monkeypatch.setattr("tsr_engine.bundle.bundle_params", lambda _: (paper, []))
    assert run(["replay", str(plain), "--set", "motion=looming"]) == 2
    assert "Set coast_foe_y to the value that `tsr calibrate` finds" in capfd.readouterr().err


@pytest.mark.usefixtures("toy_parts")
def test_evidence_folders_replay_as_before(drive: TrackedDrive, capfd: Any) -> None:
    assert run(["replay", str(drive.run)]) == 0
    assert "75 are identical" in capfd.readouterr().out


def own_models(folder: Path) -> Path:
    """A model folder with another prior."""
    for name, entry in read_manifest(SHIPPED)["components"].items():
        if name != "prior":
            shutil.copyfile(SHIPPED / entry["file"], folder / entry["file"])
    shutil.copyfile(SHIPPED / "manifest.json", folder / "manifest.json")
    prior = load_component("prior")
    save_component(Component("prior", {"table": prior.arrays["table"] * 0.5}, prior.params), folder)
    return folder


def test_own_models_are_bundled_and_extracted(drive: TrackedDrive, tmp_path: Path) -> None:
    models = tmp_path / "models"
    models.mkdir()
    own_models(models)
    used = {name: str(entry["sha256"]) for name, entry in read_manifest(models)["components"].items()}
    shipped = {name: str(entry["sha256"]) for name, entry in read_manifest(SHIPPED)["components"].items()}
    assert choose_models(shipped, [models]).folder is None
    assert choose_models(used, [SHIPPED, models]).folder == models
    assert choose_models(used, []).folder is None
    assert "not inside" in choose_models(used, []).text
    add_models(models, tmp_path / "stored")
    assert not any(path.read_bytes()[:2] == b"PK" for path in (tmp_path / "stored").iterdir())
    taken = extract_models(tmp_path / "stored", tmp_path / "taken")
    for name in used:
        a, b = load_component(name, models), load_component(name, taken)
        assert a.sha256 == b.sha256
        assert all(np.array_equal(a.arrays[key], b.arrays[key]) for key in a.arrays)


def test_invalid_models_are_refused(tmp_path: Path) -> None:
    add_models(SHIPPED, tmp_path / "stored")
    (tmp_path / "stored" / "prior.npz.model").write_bytes(b"PK")
    with pytest.raises(ImportFormatError, match="is not a model"):
        extract_models(tmp_path / "stored", tmp_path / "a")
    (tmp_path / "stored" / "prior.npz.model").unlink()
    with pytest.raises(ImportFormatError, match="lacks its model 'prior'"):
        extract_models(tmp_path / "stored", tmp_path / "b")


def test_a_model_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    add_models(SHIPPED, tmp_path / "stored")
    stored = tmp_path / "stored" / "prior.npz.model"
    head = stored.read_bytes().split(b"\n", 1)[0] + b"\n"
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("table.npy", b"x")
    packed = bytearray((tmp_path / "bomb.npz").read_bytes())
    place = packed.rfind(b"PK\x01\x02")
    packed[place + 24 : place + 28] = (0xF0000000).to_bytes(4, "little")
    stored.write_bytes(head + bytes(packed))
    with pytest.raises(ImportFormatError, match="unfolds to"):
        extract_models(tmp_path / "stored", tmp_path / "c")
