"""The pages of the formats list every option of their format, with its values; the default comes first."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tsr_engine.exchange.formats import BAD_BOXES
from tsr_engine.exchange.registry import FORMATS

PAGES = Path(__file__).resolve().parents[2] / "docs" / "formats"
ROW = re.compile(r"^\| ((?:`\w+`(?:, )?)+) \((export|import)\) \| ([^|]*)\|", re.MULTILINE)


@pytest.mark.parametrize("name", FORMATS)
def test_the_page_lists_every_option(name: str) -> None:
    known = FORMATS[name]
    text = (PAGES / str(known.docs)).read_text(encoding="utf-8")
    listed = {
        (direction, option): re.findall(r"`([\w-]+)`", values)
        for options, direction, values in ROW.findall(text)
        for option in re.findall(r"\w+", options)
    }
    switches = {("export", switch.name): switch for switch in known.export_switches} | {
        ("import", switch.name): switch for switch in known.import_switches if switch.name != BAD_BOXES.name
    }
    assert sorted(listed) == sorted(switches)
    assert {key: values for key, values in listed.items() if values and values != [*switches[key].values]} == {}
