"""Old parameter names are accepted with a warning and do not change the identity of a stored run."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tsr_engine.cli.common import make_params
from tsr_engine.errors import UsageError
from tsr_engine.evidence.header import RunHeader, VideoIdentity, read_header, write_header
from tsr_engine.params import Params
from tsr_engine.params.aliases import (
    ALIASES,
    SWITCHES,
    current_sections,
    current_settings,
    rename_warnings,
    stored_sections,
)

NAMES = {f"{section}.{leaf}" for section, leaf in Params.names()}


@pytest.mark.parametrize(("old", "new"), sorted(ALIASES.items()))
def test_the_old_name_sets_the_same_parameter(old: str, new: str) -> None:
    assert new in NAMES
    assert old not in NAMES
    section, leaf = new.split(".")
    usual = getattr(getattr(Params.preset("paper"), section), leaf)
    for name in (old, old.split(".")[1]):
        for told, value in SWITCHES.get(old.split(".")[1], {usual: usual}).items():
            assert Params().with_settings([(name, told)]) == Params().with_settings([(new, value)])


def test_the_command_line_warns_and_names_the_new_one(capsys: pytest.CaptureFixture[str]) -> None:
    params = make_params("default", ["sought_noise=7", "gate.tau=20"])
    assert (params.pipeline.search_noise, params.gate.tau) == (7.0, 20.0)
    assert capsys.readouterr().err.startswith("tsr: Parameter 'sought_noise' is now called 'search_noise'. ")
    make_params("default", ["search_noise=7"])
    assert capsys.readouterr().err == ""


def test_both_names_in_one_request_are_refused() -> None:
    assert current_settings({"closer_look": False, "tau": 3}) == {"rescore_windows": False, "tau": 3}
    with pytest.raises(UsageError, match="'closer_look' is now called 'rescore_windows'. Set one of them, not both"):
        current_settings({"closer_look": False, "rescore_windows": True})


def test_only_old_names_cause_a_warning() -> None:
    assert rename_warnings(["tau", "pipeline.search_noise"]) == []
    assert len(rename_warnings(["pipeline.sought_noise", "tight_width"])) == 2


def test_a_stored_run_with_old_names_is_valid_and_has_the_new_names(tmp_path: Path) -> None:
    header = RunHeader(VideoIdentity("a.mp4", "0" * 64, 5), Params().model_dump(mode="json"), {"detector": "1"}, {})
    write_header(tmp_path, header)
    content: dict[str, Any] = json.loads((tmp_path / "run.json").read_text())
    old = content | {"parameters": stored_sections(content["parameters"])}
    assert "sought_noise" in old["parameters"]["pipeline"]
    assert "search_noise" not in old["parameters"]["pipeline"]
    (tmp_path / "run.json").write_text(json.dumps(old))
    read = read_header(tmp_path)
    assert read.identity() == header.identity() == content["identity"]
    assert read.differences(header) == []
    assert read.parameters == current_sections(old["parameters"]) == content["parameters"]


def test_an_old_option_sets_the_equivalent_choice(capsys: pytest.CaptureFixture[str]) -> None:
    assert make_params("default", ["network_classifier=on"]).pipeline.reader == "network"
    assert capsys.readouterr().err.startswith(
        "tsr: Parameter 'network_classifier' is now called 'reader' ('network' for true, 'classifier' for false). "
    )
    assert make_params("default", ["pipeline.network_classifier=False"]).pipeline.reader == "classifier"
    assert current_settings({"network_classifier": True}) == {"reader": "network"}
    with pytest.raises(UsageError, match="'network_classifier' is true or false. Got 'both'"):
        make_params("default", ["network_classifier=both"])
    with pytest.raises(UsageError, match="must not be true or false"):
        Params().with_settings([("reader", True)])


@pytest.mark.parametrize(("switch", "choice"), [(False, "classifier"), (True, "network")])
def test_a_stored_run_with_an_old_option_is_valid_and_replays_unchanged(
    tmp_path: Path, switch: bool, choice: str
) -> None:
    parameters = Params().model_dump(mode="json")
    del parameters["pipeline"]["reader"]
    old = {**parameters, "pipeline": {**parameters["pipeline"], "network_classifier": switch}}
    asked = Params().with_settings([("reader", choice)]).model_dump(mode="json")
    header = RunHeader(VideoIdentity("a.mp4", "0" * 64, 5), asked, {"detector": "1"}, {})
    assert header.identity() == replace(header, parameters=old).identity(), "as when the switch was stored"
    write_header(tmp_path, header)
    content: dict[str, Any] = json.loads((tmp_path / "run.json").read_text())
    (tmp_path / "run.json").write_text(json.dumps(content | {"parameters": old}))
    assert read_header(tmp_path).parameters == asked
    assert stored_sections(asked) == stored_sections(old)


def test_a_new_choice_keeps_its_name() -> None:
    both = {"pipeline": {"reader": "both"}, "note": 3}
    assert stored_sections(both) == current_sections(both) == both
    odd = {"pipeline": {"network_classifier": "perhaps"}}
    assert current_sections(odd) == {"pipeline": {"reader": "perhaps"}}
