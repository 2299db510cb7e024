"""A part that is not installed is reported in one sentence: by the command line, over HTTP and by a job."""

from __future__ import annotations

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from app.failures import handle_failures
from tsr_engine.extras import MissingExtra, explained, missing_extra

SENTENCE = "The 3-D views need viser, which is not installed: pip install 'tsr[scene3d]'."


def test_a_missing_package_is_reported_with_its_extra() -> None:
    with pytest.raises(MissingExtra) as reported, explained():
        raise ModuleNotFoundError("No module named 'viser'", name="viser")
    assert str(reported.value) == SENTENCE
    assert reported.value.exit_code == 2


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named 'viserx'", name="viserx"),
        ModuleNotFoundError("No module named 'tsr_engine.gone'", name="tsr_engine.gone"),
        ModuleNotFoundError("no name"),
        ImportError("cannot import name 'x' from 'viser'", name="viser"),  # installed but broken
    ],
)
def test_other_import_errors_are_unchanged(error: ImportError) -> None:
    assert missing_extra(error) is None
    with pytest.raises(ImportError) as raised, explained():
        raise error
    assert raised.value is error


@pytest.mark.parametrize("error", [ModuleNotFoundError("x", name="viser.theme"), MissingExtra(SENTENCE)])
def test_a_route_answers_501(error: Exception) -> None:
    app = FastAPI()
    handle_failures(app)

    @app.get("/view")
    def view() -> None:
        raise error

    answer = TestClient(app).get("/view")
    assert answer.status_code == 501
    assert answer.json()["error"]["code"] == "missing_extra"
    assert answer.json()["error"]["message"] == SENTENCE


def test_other_import_errors_of_a_route_are_internal_errors() -> None:
    app = FastAPI()
    handle_failures(app)

    @app.get("/view")
    def view() -> None:
        raise ModuleNotFoundError("x", name="app.gone")

    answer = TestClient(app, raise_server_exceptions=False).get("/view")
    assert answer.status_code == 500
    assert answer.json()["error"]["code"] == "internal"
