"""Small files of CVAT for video 1.1."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.exchange.small_datasets import make_dataset, target_of
from tsr_engine.exchange.dataset import Dataset
from tsr_engine.exchange.load import read_dataset
from tsr_engine.exchange.registry import FORMATS

Read = Callable[..., Dataset]

BOX = '<box frame="{}" keyframe="{}" outside="{}" xtl="10" ytl="10" xbr="{}" ybr="22"/>'
SAMPLE = """<?xml version="1.0" encoding="utf-8"?>
<annotations>
 <version>1.1</version>
 <meta><task><mode>interpolation</mode><original_size><width>640</width><height>360</height></original_size></task></meta>
 <track id="0" label="stop" source="auto">
  <box frame="10" keyframe="1" outside="0" occluded="0" xtl="10.00" ytl="10.00" xbr="20.00" ybr="22.00" z_order="0">
    <attribute name="uid">t-7f3a</attribute><attribute name="score">0.93</attribute></box>
  <box frame="40" keyframe="1" outside="1" occluded="0" xtl="18.00" ytl="11.00" xbr="40.00" ybr="35.00" z_order="0"/>
 </track>
</annotations>
"""


def cvat_track(*boxes: str, label: str = "stop", id: int = 0) -> str:
    return f'<track id="{id}" label="{label}">\n' + "\n".join(boxes) + "\n</track>\n"


def cvat_file(*tracks: str) -> str:
    return "<annotations>\n" + "".join(tracks) + "</annotations>"


def one_track(*boxes: str, label: str = "stop") -> str:
    return cvat_file(cvat_track(*boxes, label=label))


def read_cvat(folder: Path, content: str, **switches: str) -> Dataset:
    """Read text as a file on the video of the small data set."""
    path = folder / "annotations.xml"
    path.write_text(content, encoding="utf-8")
    return read_dataset(path, target_of(make_dataset(), switches=switches), FORMATS["cvat-video"])
