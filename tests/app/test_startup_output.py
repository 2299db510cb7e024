"""The first moments of the command."""

from __future__ import annotations

import builtins
from typing import Any

import pytest

from app.cli import start


def test_ctrl_c_during_loading_is_a_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    load = builtins.__import__

    def interrupted(name: str, *rest: Any) -> Any:
        if name == "app.cli.main":
            raise KeyboardInterrupt
        return load(name, *rest)

    monkeypatch.setattr(builtins, "__import__", interrupted)
    assert start.run() == 130
    assert capsys.readouterr().err == "tsr: Interrupted.\n"
