"""``tsr labels``: every command, on a server's library and beside a running server."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from app.cli.attribute_option import parse_attribute
from app.cli.main import run
from app.settings import Settings
from app.storage.database import Database
from app.storage.models import Video
from tests.app.databases import put_tables
from tests.app.toy_server import Server
from tsr_engine.errors import UsageError
from tsr_engine.labels.files import load_set, shipped_set


class Command:
    """The command line on one data folder."""

    def __init__(self, home: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.home = home
        self._capsys = capsys

    def __call__(self, *words: object, code: int = 0) -> str:
        """The output of a command; ``code``: its expected exit code."""
        self._capsys.readouterr()
        ended = run(["labels", *map(str, words), "--home", str(self.home)])
        captured = self._capsys.readouterr()
        assert ended == code, captured.err
        text = captured.err if code or not captured.out else captured.out
        return "\n".join(line.removeprefix("tsr: ") for line in text.strip().splitlines())

    def json(self, *words: object) -> Any:
        """The JSON output of a command."""
        return json.loads(self(*words, "--json"))


@pytest.fixture
def labels(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Command:
    """The command line on an empty library."""
    monkeypatch.setenv("TSR_AUTHOR", "ada")
    settings = Settings(home=tmp_path / "home")
    settings.home.mkdir()
    put_tables(settings.home / "tsr.sqlite")
    database = Database(settings.database)
    with database.write() as session:
        session.add(Video(id="a" * 64, name="drive.mp4", path="/drives/drive.mp4", size=1, state="ready"))
    database.close()
    return Command(settings.home, capsys)


def test_labels_are_listed_shown_and_found_by_any_name(labels: Command) -> None:
    found = labels.json("list")
    assert (found["set"], found["version"], len(found["labels"])) == ("gtsrb-43", 1, 43)
    assert [each["key"] for each in found["sets"]] == ["gtsrb-43", "vienna"]
    text = labels("list")
    assert "speed-limit-20" in text
    assert "* gtsrb-43" in " ".join(text.split())
    assert labels.json("show", "Stop")["id"] == labels.json("show", "#14")["id"] == 14
    assert "shape: octagon" in labels("show", "stop")
    assert labels("show", "stopp", code=2).endswith("alias or number 'stopp'. Is it 'stop'?")
    assert labels("show", "limit", code=2).endswith("'speed limit 30 km/h', 'speed limit 50 km/h'?")
    assert labels("show", "zebra", code=2).endswith("'zebra'. The page Labels and 'tsr labels list' list the labels.")


def test_labels_are_added_with_all_fields_and_changed(labels: Command) -> None:
    said = labels("add", "no parking", "--alias", "Parkverbot", "--attribute", "bent:checkbox,mutable", "--digit", 3)
    assert said == "Added 'no parking'. It is label 43, key no-parking."
    shown = labels.json("show", "parkverbot")
    assert (shown["id"], shown["pinned"]) == (43, 3)
    assert shown["attributes"][0] | {"name": "bent", "kind": "checkbox", "mutable": True} == shown["attributes"][0]
    options = "--key k --short s --shape circle --category danger --teach ignore --colour #00ff00"
    done = labels.json("add", "x", *options.split())
    assert done["label"] | {"id": 44, "key": "k", "short": "s", "shape": "circle", "teach": "ignore"} == done["label"]
    assert labels("rename", "x", "y").startswith("Renamed 'x' to 'y'.")
    labels("alias", "y", "z", "zz")
    assert labels.json("show", "zz")["aliases"] == ["z", "zz"]
    labels("alias", "y", "z", "--remove")
    assert labels("alias", "y", "z", "--remove", code=2) == "'y' has no alias 'z'."
    assert labels("hide", "y").startswith("Hid 'y'.")
    assert labels.json("show", "y")["hidden"] is True
    assert labels("hide", "y", "--undo").startswith("Shows 'y' again.")
    assert labels("merge", "y", "no parking").startswith("Merged 'y' into 'no parking'.")
    assert labels.json("list")["labels"][44]["merged_into"] == 43
    assert labels.json("list")["version"] == 9


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        (("add", "stop"), "The name 'stop' belongs to 'stop' (label 14, key stop)."),
        (("add", "x", "--shape", "star"), "shape: Input should be 'triangle'"),
        (("add", "x", "--colour", "red"), "colour: "),
        (("add", "x", "--attribute", "a:dial"), "Expected --attribute as NAME:checkbox"),
        (("merge", "stop", "stop"), "cannot be merged into itself"),
        (("use", "none"), "There is no label set 'none'."),
        (("use", "vienna", "--video", "other.mp4"), "no video is called 'other.mp4'"),
        (("import", "none.json"), "Expected a file of labels or one of the sets gtsrb-43, vienna. Got 'none.json'."),
        (("list", "--set", "none"), "There is no label set 'none'."),
        (("export", "x.json", "--format", "xls"), "Expected a format of labels"),
        (("export", "-"), "cannot be written to standard output"),
    ],
)
def test_refusals_are_one_sentence(labels: Command, words: tuple[object, ...], reported: str) -> None:
    said = labels(*words, code=2)
    assert reported in said
    assert "Traceback" not in said
    assert labels.json("list")["version"] == 1


def test_sets_are_exported_and_imported(labels: Command, tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    labels("add", "no parking")
    assert labels("export", file).endswith(", version 2.")
    assert load_set(file).get(43).key == "no-parking"  # type: ignore[union-attr]
    assert labels("export", file, "--version", 1)
    assert load_set(file) == shipped_set("gtsrb-43")
    assert "are lost" in labels("export", file, "--format", "cvat")
    assert len(json.loads(file.read_text())) == 44
    names = tmp_path / "obj.names"
    names.write_text("stop\nno stopping\nbad\u202ename\n")
    assert labels("import", names).splitlines() == [
        "Added 1 label of 'obj.names'. 1 were already in the set.",
        "obj.names, line 3: name: it holds the control character U+202E.",
    ]
    assert labels("import", names, "--set", "team", code=2) == "There is no label set 'team'."
    assert labels("import", names, "--set", "My Team", "--create", code=2).startswith("Expected the key")
    assert labels.json("import", names, "--set", "team", "--create")["created"] is True
    assert labels("use", "team", "--video", "drive.mp4") == "drive.mp4 uses 'obj.names'."
    assert labels("use", "default", "--video", "drive.mp4").startswith("drive.mp4 uses 'GTSRB")
    assert labels("use", "team") == "The library uses 'obj.names'."
    assert len(labels.json("list")["labels"]) == 2


def test_signs_of_the_vienna_convention_are_added_and_ids_stay(labels: Command) -> None:
    done = labels.json("import", "vienna")
    assert len(done["known"]) >= 43
    assert done["added"][0]["id"] == 43
    now = labels.json("list")["labels"]
    assert [(each["id"], each["key"]) for each in now[:43]] == [(each.id, each.key) for each in shipped_set("gtsrb-43")]
    assert labels.json("import", "vienna")["added"] == []
    assert labels("use", "vienna").startswith("The library uses")


def test_commands_are_safe_beside_a_running_server(server: Server, capsys: pytest.CaptureFixture[str]) -> None:
    command = Command(server.settings.home, capsys)
    server.client.post("/api/label-sets/gtsrb-43/changes", json={"change": {"type": "add", "name": "one"}})
    assert command("add", "two").startswith("Added 'two'. It is label 44")
    assert [label["name"] for label in server.client.get("/api/labels").json()[43:]] == ["one", "two"]
    assert "was added by ada" in command("add", "one", code=2)


def test_a_folder_without_a_library_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert Command(tmp_path / "none", capsys)("list", code=3).startswith("There is no data folder at")


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("occluded:checkbox", {"name": "occluded", "kind": "checkbox", "mutable": False}),
        ("a:checkbox,mutable,default=true", {"name": "a", "kind": "checkbox", "mutable": True, "default": True}),
        ("side:select=left|right,default=left", {"values": ["left", "right"], "default": "left"}),
        ("h:number=0..5.5", {"low": 0.0, "high": 5.5}),
        ("h:number=..5,default=-1", {"low": None, "high": 5.0, "default": -1.0}),
        ("plate:text,default=a, b", {"default": "a, b"}),
    ],
)
def test_attributes_are_written_on_one_line(text: str, facts: dict[str, Any]) -> None:
    found = parse_attribute(text)
    assert found | facts == found


@pytest.mark.parametrize(
    "text", ["a", "a:", "a:dial", "a:text=b", "a:number=5", "a:number=a..b", "a:checkbox,default=1"]
)
def test_an_invalid_attribute_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="Expected --attribute as"):
        parse_attribute(text)
