"""Proposals that no page reads are dropped, except over a sleep of the computer and a clock that is set."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import pytest
from sqlalchemy import delete, select

from app.follows import service
from app.storage.models import Follow, Job
from tests.app.follows.follow_requests import LEASE_S, NO_ROWS, anchor_of, start_follow, stored_rows
from tests.app.inline_worker import run_jobs
from tests.app.toy_server import Server


def unread_for(server: Server, follow: str, seconds: float) -> None:
    """Set the time of the last request about a follow."""
    with server.context.database.write() as session:
        session.get_one(Follow, follow).asked = datetime.now(UTC) - timedelta(seconds=seconds)


def test_unrequested_proposals_are_dropped(server: Server, run: str) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    sweep_past_lease(server)
    unread_for(server, follow["id"], LEASE_S - 60)
    # a request keeps them
    server.client.get(f"/api/follows/{follow['id']}")
    with server.context.database.read() as session:
        assert datetime.now(UTC) - session.get_one(Follow, follow["id"]).asked < timedelta(seconds=LEASE_S / 2)
    unread_for(server, follow["id"], LEASE_S + 1)
    server.context.follows.sweep()
    assert stored_rows(server) == NO_ROWS


def test_finished_proposals_wait_for_a_night(server: Server, run: str) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    run_jobs(server.context)
    sweep_past_lease(server)
    unread_for(server, follow["id"], 12 * 3600)
    server.context.follows.sweep()
    assert server.client.get(f"/api/follows/{follow['id']}").status_code == 200
    unread_for(server, follow["id"], service.RESULT_LIFETIME_S + 1)
    server.context.follows.sweep()
    assert stored_rows(server) == NO_ROWS


def test_servers_leave_the_follows_of_others(server: Server, run: str, monkeypatch: pytest.MonkeyPatch) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    sweep_past_lease(server)
    with server.context.database.write() as session:
        session.scalars(select(Job).where(Job.subject == follow["id"])).one().place = "there"
    monkeypatch.setattr("app.storage.servers.this_server", lambda session: "here")
    unread_for(server, follow["id"], LEASE_S + 1)  # by the clock of this server
    server.context.follows.sweep()
    assert stored_rows(server)["follows"] == 1
    monkeypatch.setattr("app.storage.servers.this_server", lambda session: "there")
    server.context.follows.sweep()
    assert stored_rows(server) == NO_ROWS


def test_follows_without_a_job_are_dropped(server: Server, run: str) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    sweep_past_lease(server)
    with server.context.database.write() as session:
        session.execute(delete(Job))
    unread_for(server, follow["id"], LEASE_S + 1)
    server.context.follows.sweep()
    assert stored_rows(server) == NO_ROWS


def test_a_follow_survives_a_sleep_of_the_computer(server: Server, run: str, monkeypatch: pytest.MonkeyPatch) -> None:
    follow = start_follow(server, run, [anchor_of(server, run)])
    sweep_past_lease(server)
    clock = datetime.now(UTC) + timedelta(hours=8)
    monkeypatch.setattr(service, "datetime", SimpleNamespace(now=lambda zone: clock))
    server.context.follows.sweep()  # before the page could make a request
    assert server.client.get(f"/api/follows/{follow['id']}").status_code == 200
    clock -= timedelta(hours=1)  # summer time ends, or the clock is corrected
    assert server.client.get(f"/api/follows/{follow['id']}").status_code == 200
    with server.context.database.read() as session:
        assert session.get_one(Follow, follow["id"]).asked == clock
    for _ in range(10):  # now nobody asks any more
        clock += timedelta(seconds=LEASE_S / 4)
        server.context.follows.sweep()
    assert stored_rows(server) == NO_ROWS


def sweep_past_lease(server: Server) -> None:
    """Let the service sweep for longer than a lease, so that it has not just been started."""
    end = datetime.now(UTC)
    with pytest.MonkeyPatch.context() as patch:
        for step in range(5):
            then = end - timedelta(seconds=LEASE_S * (4 - step) / 2)
            patch.setattr(service, "datetime", SimpleNamespace(now=lambda zone, then=then: then))
            server.context.follows.sweep()
