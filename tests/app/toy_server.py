"""A server in this process on its own data folder."""

from __future__ import annotations

from pathlib import Path

from fastapi import FastAPI
from starlette.testclient import TestClient

from app.context import Context
from app.main import create_app
from app.settings import Settings
from app.storage.database import sqlite_file
from tests.app.databases import put_tables

SECRET = "a secret of the tests, long enough"


class Server:
    """The application and a client with all permissions."""

    def __init__(self, home: Path, **settings: object) -> None:
        values = {"home": home, "roots": (home,), "sample": False, "workers": 0, "token": SECRET, "author": "ada"}
        self.settings = Settings(**{**values, **settings})  # type: ignore[arg-type]
        file = sqlite_file(self.settings.database)
        if file is not None and not file.exists() and not self.settings.home.exists():
            self.settings.home.mkdir(parents=True)
            put_tables(file)
        self.app: FastAPI = create_app(self.settings)
        self.client = TestClient(self.app, base_url="http://127.0.0.1", raise_server_exceptions=False)
        self.client.headers["Authorization"] = f"Bearer {SECRET}"

    @property
    def context(self) -> Context:
        context: Context = self.app.state.context
        return context

    def stranger(self) -> TestClient:
        """A client without credentials."""
        return TestClient(self.app, base_url="http://127.0.0.1", raise_server_exceptions=False, follow_redirects=False)
