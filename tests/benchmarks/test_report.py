"""The report follows from the results and contains no other number."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import pytest

import benchmarks.__main__ as runner
from benchmarks import experiment
from benchmarks.experiment import ROOT, Data, Experiment, Result, Skip, machine
from benchmarks.experiments import EXPERIMENTS
from benchmarks.reporting.markdown import table
from benchmarks.reporting.report import write_report
from tsr_engine.errors import InputError


def _toy(name: str) -> Experiment:
    def report(result: Result) -> str:
        return f"It is {result.figures['value']}.\n"

    def plot(result: Result, path: Path) -> None:
        path.write_text(f"<svg>{result.figures['value']}</svg>")

    return Experiment(name, name.title(), "Is it?", lambda _: Result(name), report, plot)


def _write(folder: Path, *results: Result) -> str:
    for result in results:
        result.save(folder / "results")
    write_report([_toy("one"), _toy("two")], folder / "results", folder / "figures", folder / "REPORT.md")
    return (folder / "REPORT.md").read_text()


def test_the_page_is_written_from_results(tmp_path: Path) -> None:
    text = _write(tmp_path, Result("one", "On toys.", {"value": 41.5}, {"seed": 3}, machine()))
    assert "On toys." in text
    assert "It is 41.5." in text
    assert "python -m benchmarks one" in text
    assert "seed 3" in text
    assert "*Not run yet.*" in text  # two
    assert (tmp_path / "figures" / "one.svg").read_text() == "<svg>41.5</svg>"


def test_a_skipped_experiment_leaves_no_old_number(tmp_path: Path) -> None:
    _write(tmp_path, Result("one", "On toys.", {"value": 41.5}, {}, machine()))
    text = _write(tmp_path, Result("one", skipped="no data: the folder `toys` was not given.", machine=machine()))
    assert "41.5" not in text
    assert "*Skipped:* no data: the folder `toys` was not given." in text
    assert not (tmp_path / "figures" / "one.svg").exists()


def test_outdated_results_are_named_and_the_others_reported(tmp_path: Path) -> None:
    _write(tmp_path, Result("one", "On toys.", {"value": 41.5}, {}, machine()))
    text = _write(
        tmp_path,
        Result("one", "On toys.", {"older": 41.5}, {}, machine()),
        Result("two", "On toys.", {"value": 7}, {}, machine()),
    )
    assert "`one.json` is older than this experiment and lacks 'value'; `python -m benchmarks one`" in text
    assert "It is 7." in text
    assert "41.5" not in text
    assert not (tmp_path / "figures" / "one.svg").exists()
    with pytest.raises(KeyError, match="value"):  # a fresh result must be complete
        write_report([_toy("one")], tmp_path / "results", tmp_path / "figures", tmp_path / "REPORT.md", ["one"])


def test_results_of_another_processor_are_kept(tmp_path: Path) -> None:
    def result(processor: str, value: float, commit: str = "c0ffee") -> Result:
        return Result("one", "On toys.", {"value": value}, {}, {**machine(), "processor": processor, "commit": commit})

    def headline(found: Result) -> str:
        return f"{found.figures['value']} ms"

    first = result("Slow", 40.0).beside(None, headline)
    assert first.elsewhere == {}
    second = result("Fast", 20.0).beside(first, headline)
    third = result("Fast", 21.0).beside(second, headline)
    assert third.elsewhere == {"Slow": "40.0 ms (commit c0ffee)"}
    text = _write(tmp_path, third)
    assert "It is 21.0." in text
    assert "On Slow: 40.0 ms (commit c0ffee)." in text
    back = result("Slow", 41.0, "beef").beside(third, headline)
    assert back.elsewhere == {"Fast": "21.0 ms (commit c0ffee)"}
    assert Result("one", skipped="no data").beside(third, headline).elsewhere == {}
    both = third.beside(result("Third", 30.0), headline)
    assert both.elsewhere == {"Slow": "40.0 ms (commit c0ffee)", "Third": "30.0 ms (commit c0ffee)"}


def test_a_stored_result_stays_beside_one_of_another_processor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def measured(_: Data) -> Result:
        return Result("one", "On toys.", {"value": 30.0})

    def short(result: Result) -> str:
        return f"{result.figures['value']} ms"

    timed = replace(_toy("one"), run=measured, headline=short)
    monkeypatch.setattr(runner, "EXPERIMENTS", [timed, replace(_toy("two"), run=measured)])
    monkeypatch.setattr(runner, "ROOT", tmp_path)
    monkeypatch.setattr(runner, "RESULTS", tmp_path / "results")
    again = ["--beside", "--scratch", str(tmp_path / "scratch"), "one"]
    assert runner.main(again) == 2
    assert "There is no stored result of one. Run it without --beside." in capsys.readouterr().err
    _write(tmp_path, Result("one", "On toys.", {"value": 20.0}, {}, {**machine(), "processor": "Other"}))
    assert runner.main(again) == 0
    text = (tmp_path / "REPORT.md").read_text(encoding="utf-8")
    assert "It is 20.0." in text
    assert f"On {machine()['processor']}: 30.0 ms (commit {machine()['commit']})." in text
    _write(tmp_path, Result("one", "On toys.", {"value": 20.0}, {}, machine()))
    assert runner.main(again) == 2
    assert "The stored result of one is of this processor. Run it without --beside." in capsys.readouterr().err
    assert runner.main([*again[:-1], "two"]) == 2
    assert "No figure of two depends on the processor. Run it without --beside." in capsys.readouterr().err


def test_a_missing_folder_skips_by_name(tmp_path: Path) -> None:
    data = Data(None, None, tmp_path / "nowhere", None, tmp_path)
    for name in ("gtsdb", "clips"):
        with pytest.raises(Skip, match=f"`{name}`"):
            data.need(name)


def test_an_unreadable_file_skips_only_its_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(data: Data) -> Result:
        raise InputError(f"Expected a number for x1 in row 3 of {data.scratch / 'a.csv'}, got 'ten'.")

    def fine(data: Data) -> Result:
        return Result("two", "On toys.", {"value": 7}, {}, machine())

    monkeypatch.setattr(runner, "EXPERIMENTS", [replace(_toy("one"), run=broken), replace(_toy("two"), run=fine)])
    monkeypatch.setattr(runner, "ROOT", tmp_path)
    monkeypatch.setattr(runner, "RESULTS", tmp_path / "results")
    assert runner.main(["--scratch", str(tmp_path / "scratch")]) == 0
    text = (tmp_path / "REPORT.md").read_text(encoding="utf-8")
    assert "*Skipped:* Expected a number for x1 in row 3" in text
    assert "It is 7." in text
    assert "done" in capsys.readouterr().err


@pytest.mark.parametrize("figures", [{"value": 41.5}, {"older": 41.5}])
def test_a_skipped_experiment_leaves_its_stored_result(
    figures: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def without_data(data: Data) -> Result:
        data.need("clips")
        raise AssertionError

    monkeypatch.setattr(runner, "EXPERIMENTS", [replace(_toy("one"), run=without_data)])
    monkeypatch.setattr(runner, "ROOT", tmp_path)
    monkeypatch.setattr(runner, "RESULTS", tmp_path / "results")
    _write(tmp_path, Result("one", "On toys.", figures, {}, machine()))
    stored = (tmp_path / "results" / "one.json").read_bytes()
    assert runner.main(["--scratch", str(tmp_path / "scratch"), "one"]) == 0
    assert (tmp_path / "results" / "one.json").read_bytes() == stored
    assert ("It is 41.5." in (tmp_path / "REPORT.md").read_text(encoding="utf-8")) == ("value" in figures)
    said = capsys.readouterr().err
    assert "one ... skipped, the stored result stays: no data: the folder `clips` was not given" in said


def test_a_run_on_fewer_folders_leaves_a_fuller_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def count(data: Data) -> Result:
        return Result("one", "On toys.", {"value": data.has("clips") + data.has("foreign")})

    monkeypatch.setattr(runner, "EXPERIMENTS", [replace(_toy("one"), run=count, optional=("clips", "foreign"))])
    monkeypatch.setattr(runner, "ROOT", tmp_path)
    monkeypatch.setattr(runner, "RESULTS", tmp_path / "results")
    path = tmp_path / "results" / "one.json"
    fewer = ["--scratch", str(tmp_path / "scratch"), "--clips", str(tmp_path), "--foreign", str(tmp_path / "nowhere")]

    def value_after(arguments: list[str]) -> object:
        assert runner.main(arguments) == 0
        return Result.load(path).figures["value"]

    assert value_after([*fewer[:-1], str(tmp_path)]) == 2
    assert value_after(fewer) == 2
    assert (
        "one ... skipped, the stored result stays: it has figures of further folders. Name them with --foreign, or "
        "remove results/one.json to measure without them." in capsys.readouterr().err
    )
    Result("one", "On toys.", {"value": 7}, machine=machine()).save(path.parent)
    assert value_after(fewer) == 7, "it is not known which folders an older result used"
    path.unlink()
    assert value_after(fewer) == value_after(fewer) == 1
    assert value_after([*fewer[:-1], str(tmp_path)]) == 2


def test_experiments_name_the_folders_that_they_can_do_without() -> None:
    folders = "|".join(field.name for field in fields(Data) if "help" in field.metadata)
    for each in EXPERIMENTS:
        source = inspect.getsource(sys.modules[each.run.__module__])
        read = set(re.findall(rf"\bdata\.({folders})\b", source)) - set(re.findall(r'data\.need\("(\w+)"\)', source))
        tuning = {"tuning"} if "judged_approaches(" in source else set()
        assert read | tuning <= set(each.optional), each.name


def test_names_are_unique_and_valid_file_names() -> None:
    names = [experiment.name for experiment in EXPERIMENTS]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-z_]+", name) for name in names)


def test_an_unknown_experiment_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        runner.main(["request"])
    assert ended.value.code == 2
    assert "there is no experiment request" in capsys.readouterr().err


def test_a_second_run_in_one_scratch_folder_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runner, "RESULTS", tmp_path / "results")
    monkeypatch.setattr(runner, "write_report", lambda *_: pytest.fail("nothing was measured"))
    with runner.alone(tmp_path):
        assert runner.main(["fusion", "--scratch", str(tmp_path)]) == 2
    error_output = capsys.readouterr().err
    assert error_output.startswith(f"benchmarks: Other experiments run in {tmp_path}")
    assert "Traceback" not in error_output
    assert not (tmp_path / "results").exists()
    monkeypatch.setattr(runner, "write_report", lambda *_: None)
    assert runner.main(["fusion", "--scratch", str(tmp_path)]) == 0  # the lock ended with its holder
    assert (tmp_path / "results" / "fusion.json").is_file()


def test_the_committed_report_follows_from_the_committed_results(tmp_path: Path) -> None:
    write_report(EXPERIMENTS, ROOT / "results", tmp_path / "figures", tmp_path / "REPORT.md")
    reported = (tmp_path / "REPORT.md").read_text()
    assert reported == (ROOT / "REPORT.md").read_text()
    assert "is older than this experiment" not in reported


def test_results_of_other_experiments_do_not_change_the_code_version(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def git(*arguments: str) -> None:
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=tmp_path, check=True)

    folder = tmp_path / ROOT.name
    (folder / "results").mkdir(parents=True)
    for name in ("code.py", "REPORT.md", "results/one.json"):
        (folder / name).write_text("before")
    git("init", "--quiet")
    git("add", "--all")
    git("commit", "--quiet", "--message", "All.")
    monkeypatch.setattr(experiment, "ROOT", folder)
    clean = machine()["commit"]
    assert clean
    (folder / "results" / "one.json").write_text("after")
    (folder / "REPORT.md").write_text("after")
    assert machine()["commit"] == clean
    (folder / "code.py").write_text("after")
    assert machine()["commit"] == f"{clean}-dirty"


def test_tables_are_markdown() -> None:
    assert table([["a", "b"], ["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |\n"


def test_memory_is_measured_once_the_cache_is_full(tmp_path: Path) -> None:
    rows = [
        {"minutes": m, "frames": int(900 * m), "heap": 6.0, "renderers": held, "server": 290}
        for m, held in ((0.5, 600), (5.5, 820), (30.0, 824), (60.0, 822))
    ]
    hour = next(one for one in EXPERIMENTS if one.name == "review_hour")
    text = hour.report(Result("review_hour", figures={"playing": rows}))
    assert "hold 820 to 824 MB" in text
    assert "| 60 | 54,000 | 6.0 | 822 | 290 |" in text
    assert hour.plot is not None
    hour.plot(Result("review_hour", figures={"playing": rows}), tmp_path / "hour.svg")
    assert (tmp_path / "hour.svg").stat().st_size > 1000
