"""Archives of many small files are read like their folder, with the same error sentences."""

from __future__ import annotations

import gc
import io
import zipfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from tests.exchange.small_datasets import CLASS_NAMES, GTSRB
from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.dataset import Dataset, DatasetVideo
from tsr_engine.exchange.formats import ImportTarget
from tsr_engine.exchange.gc_threshold import infrequent_gc
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.voc.small_xml import MAX_SMALL_BYTES, small_elements
from tsr_engine.exchange.xml import elements
from tsr_engine.exchange.zip_writer import ZipWriter

FRAMES = 200
WANTED = ("filename", "size", "object")
OBJECT = (
    "<object><name>{name}</name>\n<bndbox><xmin>{x}</xmin><ymin>10.5</ymin><xmax>{end}</xmax><ymax>30</ymax></bndbox>\n"
    "<attributes><attribute><name>uid</name><value>m1</value></attribute></attributes></object>"
)


def target() -> ImportTarget:
    video = DatasetVideo("d.mp4", "0" * 64, 100, 80, FRAMES, Fraction(25), None, True, lambda: iter(()), stop=FRAMES)
    return ImportTarget(video, GTSRB)


def voc(frame: int, end: object = 40) -> str:
    inner = OBJECT.format(name=CLASS_NAMES[14], x=frame / 10, end=end)
    return f"<annotation>\n<size><width>100</width><height>80</height></size>\n{inner}\n</annotation>\n"


def files(format: str) -> dict[str, str]:
    if format == "voc":
        return {f"Annotations/frame_{k:06d}.xml": voc(k) for k in range(120)}
    labels = {f"labels/train/frame_{k:06d}.txt": f"0 0.5 0.{50 + k:03d} 0.2 0.2\n" for k in range(120)}
    return {"data.yaml": f"train: images/train\nnames: ['{CLASS_NAMES[14]}']\n", **labels}


def archive(path: Path, content: dict[str, str]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        for name, text in content.items():
            out.writestr(name, text)
    return path


def folder(path: Path, content: dict[str, str]) -> Path:
    for name, text in content.items():
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).write_text(text, encoding="utf-8", newline="")
    return path


def boxes(dataset: Dataset) -> list[tuple[int, int, tuple[float, ...]]]:
    return [
        (frame, track.label, tuple(box))
        for track in dataset.videos[0].tracks()
        for frame, box in zip(track.frames.tolist(), track.boxes.tolist(), strict=True)
    ]


@pytest.mark.parametrize("format", ["voc", "yolo"])
def test_an_archive_reads_as_its_folder_does(tmp_path: Path, format: str) -> None:
    from_archive = read_dataset(archive(tmp_path / "a.zip", files(format)), target())
    from_folder = read_dataset(folder(tmp_path / "a", files(format)), target())
    assert boxes(from_archive) == boxes(from_folder)
    assert len(boxes(from_archive)) == 120


@pytest.mark.parametrize("last", [3, 119])
def test_an_error_in_one_of_many_files_names_its_line(tmp_path: Path, last: int) -> None:
    content = files("voc")
    content[f"Annotations/frame_{last:06d}.xml"] = voc(last, end="wide")
    with pytest.raises(ImportFormatError, match=rf"frame_{last:06d}\.xml, line 4: <xmax> of <bndbox>.*'wide'"):
        read_dataset(archive(tmp_path / "a.zip", content), target())
    content = files("yolo")
    content[f"labels/train/frame_{last:06d}.txt"] = "0 0.5 0.5 0.1 0.1\n0 0.5 x 0.1 0.1\n"
    with pytest.raises(ImportFormatError, match=rf"frame_{last:06d}\.txt, line 2: must be numbers"):
        read_dataset(archive(tmp_path / "b.zip", content), target())


PLAIN = voc(1)
ODD = {
    "in a comment": PLAIN.replace("<size>", "<!-- <object> --><size>"),
    "inside another element": PLAIN.replace("<size>", "<old><object></object></old><size>"),
    "old line ends": PLAIN.replace("\n", "\r"),
    "nested too deeply": PLAIN.replace("<size>", "<a>" * 40 + "</a>" * 40 + "<size>"),
    "with a document type": "<!DOCTYPE annotation>\n" + PLAIN,
    "broken": PLAIN.replace("</annotation>", ""),
    "too large": PLAIN.replace("<size>", "\n" * MAX_SMALL_BYTES + "<size>"),
    "another root": PLAIN.replace("annotation", "annotations"),
    "UTF-16": PLAIN.encode("utf-16"),
}


@pytest.mark.parametrize("text", ODD.values(), ids=ODD.keys())
def test_the_fast_reader_declines_odd_files(text: str | bytes) -> None:
    content = text if isinstance(text, bytes) else text.encode()
    assert small_elements(content, "annotation", WANTED) is None


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        PLAIN.replace("\n", "\r\n"),
        PLAIN.replace(CLASS_NAMES[14], "a &lt; b<!-- c --><![CDATA[ <d>]]>"),
        PLAIN.replace("<name>", "<name> one <i>two</i> three ", 1),
        PLAIN.replace("<bndbox>", "<score/>\n\n<bndbox>"),
    ],
    ids=["ours", "line ends of Windows", "text in pieces", "text around an element", "an empty element"],
)
def test_both_readers_agree(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.xml").write_bytes(text.encode())
    quick = small_elements(text.encode(), "annotation", WANTED)
    assert quick is not None
    for one, other in zip(quick, elements(tmp_path / "a.xml", "annotation", WANTED), strict=True):
        assert (one.tag, one.line, one.text) == (other.tag, other.line, other.text)
        for name in ("name", "score", "bndbox", "nothing"):
            assert one.value(name) == other.value(name)
        attributes, other_attributes = one.child("attributes"), other.child("attributes")
        if attributes is not None and other_attributes is not None:
            assert attributes.table("attribute", "name", "value") == other_attributes.table(
                "attribute", "name", "value"
            )


def test_entries_of_any_size_are_written_whole() -> None:
    rng = np.random.default_rng(1)
    sizes = [0, 10, 300, 900_000, 1 << 20, 3_000_001, 5, 700_000, 700_000]
    content = {f"{k}.bin": rng.integers(0, 256, size, np.uint8).tobytes() for k, size in enumerate(sizes)}
    out = io.BytesIO()
    with ZipWriter(out) as writer:
        for k, (name, data) in enumerate(content.items()):
            if k % 2:
                writer.put(name, data)
            else:
                writer.put_stream(name, io.BytesIO(data), len(data))
    with zipfile.ZipFile(out) as back:
        assert back.testzip() is None
        assert {name: back.read(name) for name in back.namelist()} == content


def test_garbage_collection_is_restored_after_an_error() -> None:
    before = gc.get_threshold()
    inside = []

    def fail() -> None:
        with infrequent_gc():
            inside.append(gc.get_threshold())
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert inside[0][0] > before[0]
    assert gc.get_threshold() == before
