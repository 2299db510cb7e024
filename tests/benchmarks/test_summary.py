"""The report's summary follows from the results, and README has the summary's figures."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

from benchmarks.experiment import ROOT
from benchmarks.reporting.summary import ROWS, percent, summary

RESULTS = ROOT / "results"
README = (ROOT.parent / "README.md").read_text(encoding="utf-8")


def cells(row: str, text: str) -> list[str]:
    """Cells of the Markdown table row that begins with these words."""
    lines = [line for line in text.splitlines() if line.startswith(f"| {row}")]
    assert len(lines) == 1, row
    return [cell.strip() for cell in lines[0].strip("|").split("|")]


def test_every_row_has_its_figures() -> None:
    reported = summary(RESULTS)
    assert "Skipped" not in reported
    for row in ROWS:
        assert len(cells(row.what, reported)) == 3


def test_a_row_follows_from_its_results(tmp_path: Path) -> None:
    shutil.copy(RESULTS / "recordings.json", tmp_path)
    result = json.loads((tmp_path / "recordings.json").read_text())
    result["figures"]["drives"][0]["megabytes"] = 12.34
    (tmp_path / "recordings.json").write_text(json.dumps(result))
    reported = summary(tmp_path)
    assert "12.3 MB in" in reported
    assert reported.count("\n| ") == 3, "only the row whose results are there, under its head"


def test_worse_figures_than_a_peer_are_named(tmp_path: Path) -> None:
    for name in ("trackers", "stress"):
        shutil.copy(RESULTS / f"{name}.json", tmp_path)
    result = json.loads((tmp_path / "trackers.json").read_text())
    groups = result["figures"]["groups"]
    groups["turn"]["SORT"]["shared"]["theirs"] = groups["turn"]["SORT"]["shared"]["ours"] / 2
    groups["blur"]["SORT"]["coverage"] = 1.5
    groups["shake"]["OC-SORT"]["MOTA"] = groups["shake"]["default"]["MOTA"] + 0.25
    (tmp_path / "trackers.json").write_text(json.dumps(result))
    reported = summary(tmp_path)
    assert "not lower than SORT (turn)" in reported
    assert "coverage below SORT (blur)" in reported
    assert "OC-SORT's under shake by up to 0.250" in reported


def test_skipped_and_older_results_give_no_number(tmp_path: Path) -> None:
    shutil.copy(RESULTS / "recordings.json", tmp_path)
    path = tmp_path / "recordings.json"
    result = json.loads(path.read_text())
    path.write_text(json.dumps({**result, "figures": {}}))
    assert "*Skipped:* the results have no 'drives'" in summary(tmp_path)
    path.write_text(json.dumps({**result, "skipped": "no data"}))
    assert summary(tmp_path) == ""


def test_shares_are_percentages() -> None:
    assert [percent(share) for share in (0.9722, 1.0, 0.0)] == ["97.2 %", "100 %", "0.0 %"]


def test_readme_has_the_figures_of_the_summary() -> None:
    reported = summary(RESULTS)
    rows = ("detection: AP", "signs classified", "time of", "review screen", "accuracy compared")
    found = {row: cells(row, reported)[1] for row in rows}
    signs, false_tracks, _ = cells("tracking: signs found", reported)[1].split(", ")
    error = cells("tracking: coverage", reported)[1].split()[2]
    ours, theirs = re.findall(r"\((\d+) ms against (\d+);", found["time of"])[0]
    assert cells("detection, 43", README)[1] == f"AP {found['detection: AP'].split(',')[0]} at IoU 0.5"
    assert cells("labels of tracks", README)[1] == f"{found['signs classified'].split()[0]} right"
    assert cells("tracks: signs found", README)[1] == f"{signs}, {false_tracks}, {error}"
    slower, share = re.findall(r"Xeon.*: detection ([\d.]+) ms, ([\d.]+) of the network's time", found["time of"])[0]
    assert cells("detection of a 720x576", README)[1] == (
        f"{ours} ms (a YOLO11n-size network: {theirs} ms); on a slower Xeon {slower} ms, {share} of the network's time"
    )
    pattern = r"against ([\d.]+), .* coverage (\S+ %) against (\S+ %), mean Eq. 7 ([\d.]+) against ([\d.]+)"
    ap, covered, covers, exact, error = re.findall(pattern, found["accuracy compared"])[0]
    text = README.replace("\n", " ")
    assert f"the same GTSDB scenes, has AP {ap}. " in text
    assert f"covers {covers} of the signs' frames with a mean Eq. 7 of {error}; " in text
    assert f"tsr covers {covered} with {exact}" in text
    assert f"p95 {cells('review screen', README)[1]}" == found["review screen"].split(",")[0]


def test_readme_has_five_figures() -> None:
    table = README.split("## Figures")[1].split("\n\n")[1].splitlines()[2:]
    assert len(table) == 5
