"""The pages for users name every command, and their links are valid."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest
import typer.main

from app.cli.main import register
from tsr_engine.cli import train
from tsr_engine.cli.main import app, run
from tsr_engine.errors import InputError
from tsr_engine.training.corrections import exports
from tsr_engine.training.public import network_classifier, train_parts

register()
TSR = typer.main.get_command(app)
ROOT = Path(__file__).resolve().parents[2]
COMMANDS = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "benchmarks").rglob("*.md")),
    *sorted((ROOT / ".github").rglob("*.md")),
]
LINK = re.compile(r"\[[^]]*\]\(([^)\s]+)\)")
SHOWN = re.compile(r"(?:^(?: {4})?|`)tsr ([a-z][^`\n#]*)", re.MULTILINE)
"""A command in a block or in a sentence, up to its comment."""


def commands() -> list[str]:
    """Every command with its group, such as ``track`` or ``eval tracking``."""
    names: list[str] = []
    for name, command in TSR.commands.items():  # type: ignore[attr-defined]
        inner = getattr(command, "commands", None)
        names += [name] if inner is None else [f"{name} {leaf}" for leaf in inner]
    return sorted(names)


@pytest.mark.parametrize("name", commands())
def test_docs_have_an_example_of_every_command(name: str) -> None:
    examples = [line for line in COMMANDS.splitlines() if line.startswith(f"    tsr {name}")]
    assert examples, f"docs/cli.md has no example of `tsr {name}`"


def test_options_of_shown_commands_exist() -> None:
    unknown, options = [], 0
    for page in PAGES:
        if page.name == "CHANGELOG.md":  # it also names former options
            continue
        for shown in SHOWN.findall(re.sub(r"\\\n\s*", " ", page.read_text(encoding="utf-8"))):
            command, words = TSR, shown.split("  ")[0].split()
            while words and words[0] in getattr(command, "commands", {}):
                command = command.commands[words.pop(0)]  # type: ignore[attr-defined]
            if hasattr(command, "commands"):
                continue  # a sentence that begins with tsr, or the name of a group
            known = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
            given = [word.split("=")[0].rstrip(".,;:)") for word in words if word.startswith("--")]
            unknown += [f"{page.relative_to(ROOT)}: {shown}" for name in given if name not in known]
            options += len(given)
    assert options > 150
    assert unknown == []


def test_shown_trainings_name_the_data_that_they_need(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def begin(*asked: object) -> None:
        raise InputError("begun")

    monkeypatch.setattr(train_parts, "train_component", begin)
    monkeypatch.setattr(network_classifier, "train_network", begin)
    monkeypatch.setattr(exports, "open_export", begin)
    monkeypatch.setattr(train, "require_extra", lambda name: None)
    monkeypatch.chdir(tmp_path)
    for folder in ("GTSDB", "GTSRB", "models"):
        (tmp_path / folder).mkdir()
    (tmp_path / "drive.mp4").touch()
    lines = [line for line in COMMANDS.splitlines() if line.startswith("    tsr train ")]
    assert len(lines) > 8
    for line in lines:
        run(line.split("#")[0].split()[1:])
        assert capsys.readouterr().err.endswith("tsr: begun\n"), line


def anchors(page: Path) -> set[str]:
    """Anchors that a forge generates for the headings of a page."""
    headings = [line.lstrip("#").strip() for line in page.read_text(encoding="utf-8").splitlines() if line[:1] == "#"]
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_are_valid(page: Path) -> None:
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if target.startswith(("http://", "https://", "mailto:")):
            continue
        name, _, anchor = target.partition("#")
        found = (page.parent / name).resolve() if name else page
        assert found.exists(), f"{page.relative_to(ROOT)} links to {target}, which is not there"
        if anchor:
            assert anchor in anchors(found), f"{page.relative_to(ROOT)} links to {target}, which has no such heading"


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/releasing.md"])
def test_named_files_exist(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    places = re.findall(r"`((?:app|benchmarks|docs|static|tests|tsr_engine)/[\w./-]+)`", text)
    assert places
    assert [place for place in places if not (ROOT / place).exists()] == []


def test_named_tests_exist() -> None:
    known = {path.stem for path in (ROOT / "tests").rglob("test_*.py")}
    for path in (ROOT / "tests").rglob("test_*.py"):
        known |= set(re.findall(r"^ *(?:async )?def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE))
    named = {
        (page.name, name) for page in PAGES for name in re.findall(r"[`:](test_\w+)`", page.read_text(encoding="utf-8"))
    }
    assert len(named) > 30
    assert sorted(f"{page}: {name}" for page, name in named if name not in known) == []


def test_named_attributes_exist() -> None:
    sources = [path for place in ("app", "benchmarks", "tsr_engine") for path in (ROOT / place).rglob("*.py")]
    code = "\n".join(path.read_text(encoding="utf-8") for path in sources)
    known, owners = set(re.findall(r"\w+", code)), set(re.findall(r"^class (\w+)", code, re.MULTILINE))
    owners |= {path.stem for path in sources} | {path.parent.name for path in sources}
    named = {
        (page.name, name)
        for page in PAGES
        if page.name != "CHANGELOG.md"  # it also names former modules
        for name in re.findall(r"`([a-zA-Z_]\w*(?:\.\w+)+)(?:\(\))?`", page.read_text(encoding="utf-8"))
        if name.partition(".")[0] in owners
    }
    assert len(named) > 60
    assert sorted(f"{page}: {name}" for page, name in named if not known.issuperset(name.split("."))) == []


def test_the_architecture_page_lists_every_module_outside_a_folder() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = {word for code in re.findall(r"`([^`\n]+)`", text) for word in re.findall(r"\w+", code)}
    modules = {path.stem for place in ("app", "tsr_engine") for path in (ROOT / place).glob("[!_]*.py")}
    assert sorted(modules - named) == []


def test_the_architecture_page_lists_every_folder() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    places = [ROOT / "app", ROOT / "tsr_engine", ROOT / "static" / "js"]
    endings = ("py", "js", "json")
    found = [(place, path) for place in places for ending in endings for path in place.rglob(f"*.{ending}")]
    folders = {path.parent.relative_to(place) for place, path in found} - {Path()}
    assert len(folders) > 60
    count = Counter(folder.name for folder in folders)
    named = set(re.findall(r"`([\w/]+)`", text))
    by_name = {folder for folder in folders if count[folder.name] == 1 and folder.name in named}
    assert sorted(str(folder) for folder in folders - by_name if "/".join(folder.parts[-2:]) not in named) == []


def test_the_moving_picture_stays_small() -> None:
    picture = ROOT / "docs" / "pictures" / "review.webp"
    assert picture.read_bytes()[8:12] == b"WEBP"
    assert picture.stat().st_size < 1_500_000
