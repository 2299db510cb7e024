"""Signs of a ground truth are taken over into the corrections of a run."""

from __future__ import annotations

from typing import Any

import pytest

from app.storage.ground_truth_rows import COLUMNS
from tests.app.exchange.exchange_client import ExchangeClient

HEAD = ",".join(COLUMNS)


def corner_rows(sign: int, label: int, frames: range, ignore: int = 0) -> list[str]:
    """A sign in the picture's corner, outside all tracks of the run."""
    return [f"{k},{sign},1,1,13,13,{label},1,{ignore}" for k in frames]


TWO_SIGNS = [
    *corner_rows(1, 14, range(3, 9)),
    *[row.replace(",1,1,13,13,", ",1,40,13,52,") for row in corner_rows(2, 17, range(5))],
]


def truth(api: ExchangeClient, rows: list[str]) -> str:
    """A ground truth of the server's video."""
    content = "\n".join([HEAD, *rows]) + "\n"
    answer = api.server.client.put(f"/api/videos/{api.video_id}/ground-truths/boxes", content=content)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def docs(api: ExchangeClient) -> dict[str, Any]:
    """The run's documents by key."""
    return {doc["key"]: doc for doc in api.get(f"/api/runs/{api.run_id}/annotation")["docs"]}


def take(api: ExchangeClient, given: str, signs: list[int]) -> Any:
    """Request it; returns the answer."""
    return api.server.client.post(f"/api/runs/{api.run_id}/take-over", json={"truth": given, "signs": signs})


@pytest.mark.parametrize("label", [14, "stop", "Stop"])
def test_all_signs_of_a_label_by_its_id_key_or_name(api: ExchangeClient, label: int | str) -> None:
    given = truth(api, TWO_SIGNS)
    body = {"truth": given, "label": label}
    answer = api.server.client.post(f"/api/runs/{api.run_id}/take-over", json=body).json()
    assert (answer["made"], answer["changed"]) == (1, 0)
    api.undo()


@pytest.mark.parametrize(
    ("label", "hint"), [("no such sign", "The page Labels and 'tsr labels list'"), ("stopp", "Is")]
)
def test_an_unknown_label_is_refused_with_the_way_to_the_list(api: ExchangeClient, label: str, hint: str) -> None:
    body = {"truth": truth(api, corner_rows(1, 14, range(4))), "label": label}
    answer = api.server.client.post(f"/api/runs/{api.run_id}/take-over", json=body)
    assert answer.status_code == 422
    assert f"has the key, name, alias or number {label!r}. {hint}" in answer.json()["error"]["message"]


def test_signs_become_tracks_and_one_undo_reverts_all(api: ExchangeClient) -> None:
    before = docs(api)
    given = truth(api, TWO_SIGNS)
    answer = take(api, given, [1, 2]).json()
    assert (answer["made"], answer["changed"], answer["same"]) == (2, 0, 0)
    made = {doc["class_id"]: doc for key, doc in docs(api).items() if key not in before}
    assert set(made) == {14, 17}
    assert sorted(map(int, made[14]["keys"])) == [3, 8], "a box that stands still needs its ends only"
    assert made[14]["keys"]["3"]["box"] == [1, 1, 13, 13]
    api.undo()
    left = {key: doc for key, doc in docs(api).items() if not doc["gone"]}
    assert left.keys() == {key for key, doc in before.items() if not doc["gone"]}


def test_a_sign_on_a_track_corrects_it_once(api: ExchangeClient) -> None:
    tracks = api.get(f"/api/runs/{api.run_id}/tracks")
    lane = api.get(f"/api/runs/{api.run_id}/tracks/{tracks['id'][0]}")
    boxes = list(zip(lane["frame"], lane["box"], strict=True))
    rows = [f"{k},7,{x1 + 1},{y1},{x2 + 1},{y2},3,1,0" for k, (x1, y1, x2, y2) in boxes]
    given = truth(api, rows)
    answer = take(api, given, [7]).json()
    assert (answer["made"], answer["changed"]) == (0, 1)
    key = f"m{tracks['id'][0]}"
    assert docs(api)[key]["class_id"] == 3
    assert docs(api)[key]["review"] == "open", "a verdict is for the person to give"
    again = take(api, given, [7]).json()
    assert (again["made"], again["changed"], again["same"], again["op_id"]) == (0, 0, 1, None)
    api.undo()


@pytest.mark.parametrize(
    ("signs", "status", "words"),
    [([9], 422, "has no sign 9"), ([1], 409, "marked to be ignored"), ([], 422, "name signs, or a label")],
)
def test_invalid_requests_are_refused(api: ExchangeClient, signs: list[int], status: int, words: str) -> None:
    before = docs(api)
    answer = take(api, truth(api, corner_rows(1, 14, range(4), ignore=1)), signs)
    assert answer.status_code == status, answer.text
    assert words in answer.text
    assert docs(api) == before
