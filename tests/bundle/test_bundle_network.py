"""A run with an ONNX detector: the bundle contains the network, or names the network that it needs."""

from __future__ import annotations

import hashlib
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests import toy_pipeline
from tests.bundle.tracked_drive import TrackedDrive
from tsr_engine.bundle import network as network_module
from tsr_engine.bundle import open_bundle
from tsr_engine.bundle.evidence_slice import write_slice
from tsr_engine.bundle.network import network_of
from tsr_engine.cli.main import run
from tsr_engine.errors import ImportFormatError, ModelError, UsageError
from tsr_engine.evidence import EvidenceReader

NETWORK = b"the weights of a network"
DIGEST = hashlib.sha256(NETWORK).hexdigest()


@pytest.fixture(scope="module")
def networked(drive: TrackedDrive, tmp_path_factory: pytest.TempPathFactory) -> TrackedDrive:
    """The toy drive, with a header that names a network as its detector."""
    folder = tmp_path_factory.mktemp("networked") / "run"
    with EvidenceReader(drive.run) as reader:
        models = {"classifier": "c" * 64, "onnx 320x192 v5": DIGEST}
        write_slice(reader, folder, 0, 75, replace(reader.header, models=models))
    return drive._replace(run=folder)


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    path = tmp_path / "signs.onnx"
    path.write_bytes(NETWORK)
    return path


@pytest.fixture
def used_networks(drive: TrackedDrive, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Networks that replays load. A replay with a network stops there; one without runs the toy detector."""
    found: list[Any] = []

    def load(params: Any, folder: Path | None = None, network: Any = None) -> Any:
        found.append(None if network is None else (network.path.read_bytes(), network.size, network.layout))
        if network is not None:
            raise ModelError("Loaded, which is enough.")
        return toy_pipeline.components(params)

    monkeypatch.setattr("tsr_engine.pipeline.load_components", load)
    return found


def readme(path: Path) -> str:
    with zipfile.ZipFile(path) as archive:
        return " ".join(archive.read("README.txt").decode().split())


def test_a_bundled_network_is_run_on_request(
    networked: TrackedDrive, weights: Path, used_networks: list[Any], tmp_path: Path, capfd: Any
) -> None:
    path = networked.bundle(tmp_path / "bug.zip", network=weights).path
    assert "tsr replay BUNDLE.zip --bundled-models" in readme(path)
    assert f"SHA-256 {DIGEST}), which is inside" in readme(path)
    assert run(["replay", str(path)]) == 4, "a stranger's network is not run by itself"
    assert "--bundled-models" in capfd.readouterr().err
    assert used_networks == []
    with open_bundle(path) as bundle:
        assert bundle.manifest.network is not None
        assert bundle.manifest.network.inside
        assert (bundle.folder / "network.onnx").read_bytes() == NETWORK


def test_a_missing_network_is_named_by_its_hash(
    networked: TrackedDrive, weights: Path, used_networks: list[Any], tmp_path: Path, capfd: Any
) -> None:
    made = networked.bundle(tmp_path / "bug.zip")
    assert any("is NOT inside" in warning and DIGEST in warning for warning in made.warnings)
    assert "tsr replay BUNDLE.zip --onnx FILE" in readme(made.path)
    assert run(["replay", str(made.path)]) == 4
    reported = capfd.readouterr().err
    assert f"an ONNX network (320x192, v5, SHA-256 {DIGEST}), which is not in the bundle" in reported
    assert "--onnx FILE" in reported
    assert used_networks == []
    assert run(["replay", str(made.path), "--onnx", str(weights)]) == 4
    assert "Loaded, which is enough." in capfd.readouterr().err
    assert used_networks == [(NETWORK, (320, 192), "v5")]
    assert run(["replay", str(made.path), "--other-models", "--json"]) == 20
    assert used_networks[1:] == [None]
    changed = capfd.readouterr().out
    assert "The model onnx 320x192 v5 is another than in the run." in changed


def test_bundled_models_include_the_network(
    networked: TrackedDrive, weights: Path, used_networks: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = networked.bundle(tmp_path / "bug.zip", network=weights).path
    monkeypatch.setattr("tsr_engine.bundle.bundled_models", lambda bundle: None)  # those of the package
    assert run(["replay", str(path), "--bundled-models"]) == 4
    assert used_networks == [(NETWORK, (320, 192), "v5")]


def test_wrong_networks_are_refused(
    drive: TrackedDrive,
    networked: TrackedDrive,
    weights: Path,
    plain: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(UsageError, match="used no ONNX network"):
        drive.bundle(tmp_path / "a.zip", network=weights)
    other = tmp_path / "other.onnx"
    other.write_bytes(b"another")
    with pytest.raises(UsageError, match="is not the network of the run"):
        networked.bundle(tmp_path / "a.zip", network=other)
    assert run(["replay", str(plain), "--onnx", str(weights)]) == 2
    assert run(["replay", str(drive.run), "--onnx", str(weights)]) == 2
    monkeypatch.setattr(network_module, "MAX_BYTES", 5)
    made = networked.bundle(tmp_path / "large.zip", network=weights)
    assert made.manifest.network is not None
    assert not made.manifest.network.inside


def test_an_exchanged_network_is_refused(networked: TrackedDrive, weights: Path, tmp_path: Path) -> None:
    path = networked.bundle(tmp_path / "bug.zip", network=weights).path
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    content["network.onnx"] = b"x" * len(NETWORK)
    manifest = json.loads(content["manifest.json"])
    entry = next(one for one in manifest["files"] if one["name"] == "network.onnx")
    entry["sha256"] = hashlib.sha256(content["network.onnx"]).hexdigest()
    content["manifest.json"] = json.dumps(manifest).encode()
    with zipfile.ZipFile(tmp_path / "bad.zip", "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    with pytest.raises(ImportFormatError, match="not the one of the run"), open_bundle(tmp_path / "bad.zip"):
        pass


def test_bundles_without_a_network_are_read_by_earlier_versions(plain: Path) -> None:
    with zipfile.ZipFile(plain) as archive:
        assert "network" not in json.loads(archive.read("manifest.json"))


@pytest.mark.parametrize(
    ("name", "found"),
    [("onnx 640x480 v8", (640, 480, "v8")), ("onnx 0x1 v8", None), ("onnx 640x640 v9", None), ("detector", None)],
)
def test_names_of_networks_are_checked(name: str, found: Any) -> None:
    facts = network_of({"classifier": "a" * 64, name: "b" * 64})
    assert (None if facts is None else (facts.width, facts.height, facts.layout)) == found
