"""Randomly damaged model folders and networks are refused in a sentence, or usable.

``python -m tests.attack.damaged_models SEED COUNT`` loads them in this process, with 3 GB of memory.
"""

from __future__ import annotations

import hashlib
import io
import json
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from onnx import TensorProto, helper

from tests.attack.concurrent_editors import BrokenGuaranteeError
from tests.attack.damage import damaged, damaged_archive, zipped
from tsr_engine.errors import ModelError
from tsr_engine.io.models import MANIFEST, SHIPPED, read_manifest
from tsr_engine.params import Params
from tsr_engine.pipeline.components import Network, load_components, load_network

__all__ = ["load_damaged"]

_MEMORY = 3 << 30
_PARTS = ("detector", "prior", "classifier", "online")
_OBJECTS, _EXTERNAL_WEIGHTS = "objects", "network whose weights lie elsewhere"
"""Damage that runs code or reads other files where it is believed: never usable."""


def load_damaged(folder: Path, rng: random.Random, count: int) -> str:
    """Load so many damaged models in a separate process.

    Raises:
        BrokenGuaranteeError: a model ended the process, or raised anything but ``ModelError``.
    """
    command = [sys.executable, "-m", "tests.attack.damaged_models", str(rng.getrandbits(32)), str(count)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2])
    if done.returncode:
        raise BrokenGuaranteeError(f"loading models ended with {done.returncode}: {done.stdout}{done.stderr[-2000:]}")
    return done.stdout.strip()


def network(external_file: str | None = None) -> bytes:
    """A small network that runs as a detector of 32x32 px: boxes and scores of 20 places.

    Args:
        external_file: an external file that the network names for its weights.
    """
    x, y = helper.make_tensor_value_info("x", 1, [1, 3, 32, 32]), helper.make_tensor_value_info("y", 1, [1, 5, 20])
    weights = helper.make_tensor("w", 1, [100, 3, 32, 32], [1.0] * (100 * 3 * 32 * 32))
    if external_file is not None:
        weights = TensorProto(name="w", data_type=1, dims=weights.dims, data_location=TensorProto.EXTERNAL)
        weights.external_data.add(key="location", value=external_file)
    shape = helper.make_tensor("s", TensorProto.INT64, [3], [1, 5, 20])
    nodes = [helper.make_node("Conv", ["x", "w"], ["c"]), helper.make_node("Reshape", ["c", "s"], ["y"])]
    graph = helper.make_graph(nodes, "g", [x], [y], [weights, shape])
    return bytes(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)]).SerializeToString())


def damaged_folder(folder: Path, rng: random.Random) -> str:
    """Damage one file of a model folder and correct its sum; returns a description of the damage."""
    name = rng.choice((*_PARTS, MANIFEST))
    if name == MANIFEST:
        path = folder / MANIFEST
        path.write_bytes(damaged(path.read_bytes(), rng))
        return MANIFEST
    manifest = read_manifest(folder)
    entry = manifest["components"][name]
    path = folder / entry["file"]
    kind = rng.choice(("bytes", _OBJECTS, "huge", "lacking"))
    if kind == "bytes":
        content = damaged_archive(path.read_bytes(), rng)
    else:
        with np.load(path) as archive:
            arrays = {key: archive[key] for key in archive.files}
        key = rng.choice(sorted(arrays))
        if kind == "lacking":
            del arrays[key]
        files = {f"{each}.npy": npy_bytes(array) for each, array in arrays.items()}
        if kind == _OBJECTS:
            files[f"{key}.npy"] = npy_bytes(np.array([{}], dtype=object))
        elif kind == "huge":  # the header states a far larger size
            head = npy_bytes(np.zeros(8)).replace(b"(8,)", b"(1" + b"0" * rng.randint(9, 17) + b",)")
            files[f"{key}.npy"] = head[:128]
        content = zipped(files)
    path.write_bytes(content)
    entry["sha256"] = hashlib.sha256(content).hexdigest()
    (folder / MANIFEST).write_text(json.dumps(manifest))
    return f"{name}, {kind}"


def npy_bytes(array: np.ndarray) -> bytes:
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def main(seed: int, count: int) -> int:
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    rng, refused, slowest = random.Random(seed), 0, 0.0
    sound_network = network()
    with tempfile.TemporaryDirectory() as name:
        sound = Path(name) / "sound"
        sound.mkdir()
        for file in {MANIFEST, *(read_manifest(SHIPPED)["components"][part]["file"] for part in _PARTS)}:
            shutil.copy(SHIPPED / file, sound / file)
        load_network(Network(write_file(sound / "a.onnx", sound_network), (32, 32)), Params())
        for number in range(count):
            began = time.monotonic()
            damage = "network"
            try:
                if number % 3 == 0:
                    content = damaged(sound_network, rng)
                    if rng.random() < 0.2:
                        damage, content = (
                            _EXTERNAL_WEIGHTS,
                            network(rng.choice(("/etc/passwd", "../sound/a.onnx", "b.bin"))),
                        )
                    path = write_file(Path(name) / "a.onnx", content)
                    load_network(Network(path, (32, 32)), Params())
                else:
                    folder = Path(name) / "damaged"
                    shutil.rmtree(folder, ignore_errors=True)
                    shutil.copytree(sound, folder)
                    damage = damaged_folder(folder, rng)
                    load_components(Params(), folder)
                if damage == _EXTERNAL_WEIGHTS or damage.endswith(_OBJECTS):
                    raise BrokenGuaranteeError("it was loaded")
            except ModelError:
                refused += 1
            except BaseException:
                print(f"model {number} of seed {seed} ({damage}):", flush=True)
                raise
            slowest = max(slowest, time.monotonic() - began)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    print(f"{count} damaged models: {refused} refused, {count - refused} usable, slowest {slowest:.1f} s, {peak} MiB")
    return 0


def write_file(path: Path, content: bytes) -> Path:
    """Write a file."""
    path.write_bytes(content)
    return path


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2])))
