"""Settings from the caller and from variables; wrong ones are refused in one sentence, all are documented."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from sqlalchemy import make_url

from app.jobs.supervisor import as_environment
from app.settings import Settings, load_settings
from tsr_engine.errors import UsageError

ROOT = Path(__file__).parents[2]


def test_variables_and_values(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TSR_PORT", "9001")
    monkeypatch.setenv("TSR_ROOTS", f"{tmp_path}{os.pathsep}{tmp_path / 'b'}")
    monkeypatch.setenv("TSR_ALLOWED_HOSTS", "a.example, b.example")
    settings = load_settings(home=tmp_path / "home", workers=None)
    assert settings.port == 9001
    assert settings.roots == (tmp_path.resolve(), (tmp_path / "b").resolve())
    assert settings.allowed_hosts == ("a.example", "b.example")
    assert settings.workers == 1
    assert load_settings(port=7).port == 7
    assert make_url(settings.database).database == str(tmp_path / "home" / "tsr.sqlite")


@pytest.mark.parametrize(("name", "value"), [("port", 70000), ("workers", -1), ("token", "short"), ("max_pixels", "x")])
def test_a_wrong_value_is_one_sentence(name: str, value: object) -> None:
    with pytest.raises(UsageError, match=f"TSR_{name.upper()}"):
        load_settings(**{name: value})


def test_a_wrong_token_is_not_printed() -> None:
    with pytest.raises(UsageError, match="TSR_TOKEN.* at least 16 characters") as refused:
        load_settings(token="geheim")
    assert "geheim" not in str(refused.value)


@pytest.mark.parametrize("host", ["https://tsr.example", "tsr.example:8443", "tsr.example/", "*", "::1"])
def test_an_allowed_host_that_no_request_can_name_is_refused(host: str) -> None:
    with pytest.raises(UsageError, match=re.escape(f"{host!r} is not a name of a host such as tsr.example")) as refused:
        load_settings(allowed_hosts=f"a.example,{host}")
    assert "Value error" not in str(refused.value)
    assert load_settings(allowed_hosts="a-b.example,[fe80::1],10.0.0.7").allowed_hosts[1] == "[fe80::1]"


@pytest.mark.parametrize("hosts", [(), ("x.example",), ("x.example", "y.example")])
def test_workers_get_the_same_settings(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, hosts: tuple[str, ...]) -> None:
    roots = (tmp_path, Path("/"), tmp_path / "a:b", tmp_path / " [c], d ")
    settings = load_settings(
        home=tmp_path / "h:i",
        roots=roots,
        allowed_hosts=hosts,
        author="ada",
        sample=False,
        port=0,
        trusted_proxies=("10.0.0.0/24", "::1") if hosts else (),
    )
    assert len(settings.roots) == len(roots)
    for name, value in as_environment(settings).items():
        monkeypatch.setenv(f"TSR_{name.upper()}", value)
    assert load_settings() == settings


def test_the_document_names_every_setting() -> None:
    text = (ROOT / "docs" / "server.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*?) \|", text, flags=re.MULTILINE))
    assert set(rows) == set(Settings.model_fields)
    for name, field in Settings.model_fields.items():
        if isinstance(field.default, bool | int | str):
            assert rows[name].strip("`") == str(field.default), name
        assert field.description, name


def test_engine_processes_share_the_cores(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("app.settings.usable_cores", lambda: 9)
    assert [load_settings(home=tmp_path, workers=n).run_cores for n in (0, 1, 2, 4, 20)] == [9, 9, 4, 2, 1]
    assert load_settings(home=tmp_path, workers=4, cores=7).run_cores == 7
    monkeypatch.setattr("app.settings.usable_cores", lambda: 200)
    assert load_settings(home=tmp_path).run_cores == 16
