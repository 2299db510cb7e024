"""The frame table has exact times and survives storage."""

from __future__ import annotations

import io
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsr_engine.errors import InputError
from tsr_engine.io.frame_table import FrameLedger, FrameTable


@st.composite
def tables(draw: st.DrawFn) -> FrameTable:
    pts = sorted(draw(st.sets(st.integers(-(2**40), 2**40), max_size=12)))
    n = len(pts)
    flags = st.lists(st.booleans(), min_size=n, max_size=n)
    stamps = draw(st.one_of(st.just(pts), st.lists(st.integers(0, 2**50), min_size=n, max_size=n)))
    complete = draw(st.booleans())
    return FrameTable(
        draw(st.fractions(min_value=Fraction(1, 10**6), max_value=10, max_denominator=2**31)),
        np.array(pts, dtype=np.int64),
        np.array(stamps, dtype=np.int64),
        np.array(draw(flags), dtype=np.bool_),
        np.array(draw(flags), dtype=np.bool_),
        n if complete else draw(st.integers(0, n)),
        complete,
    )


def table_of(pts: list[int], base: Fraction = Fraction(1, 30000)) -> FrameTable:
    array = np.array(pts, dtype=np.int64)
    none = np.zeros(len(pts), dtype=np.bool_)
    return FrameTable(base, array, array, none, none, len(pts), complete=True)


@given(tables())
def test_tables_round_trip_through_archives(table: FrameTable) -> None:
    stream = io.BytesIO()
    np.savez(stream, **table.to_arrays())  # type: ignore[arg-type]
    stream.seek(0)
    with np.load(stream, allow_pickle=False) as archive:
        assert FrameTable.from_arrays(archive) == table


def test_times_are_exact() -> None:
    table = table_of([0, 1001, 2002, 3003])
    assert table.time(3) == Fraction(1001, 10000)
    assert table.interval() == Fraction(1001, 30000)
    with pytest.raises(IndexError, match=r"0\.\.3\. Got 4"):
        table.time(4)


def test_the_interval_is_the_median_step() -> None:
    assert table_of([0, 40, 80, 500, 540], Fraction(1, 1000)).interval() == Fraction(40, 1000)
    assert table_of([7]).interval() == Fraction(1, 25)


def test_a_frame_is_reached_from_the_key_frame_at_or_before_it() -> None:
    table = replace(table_of([0, 1, 2, 3, 4]), key=np.array([False, True, False, True, False]))
    assert [table.key_at_or_before(k) for k in range(5)] == [None, 1, 1, 3, 3]


@pytest.mark.parametrize(
    "damage",
    [
        {"header": [99, 1, 30000, 3, 1]},
        {"header": [1, 0, 1, 3, 1]},
        {"header": [1, 1, 0, 3, 1]},
        {"header": [1]},
        {"header": [1, 1, 30000, 9, 1]},
        {"pts": ["no", "no", "no"]},
        {"key": [True]},
        {"stamps": [1]},
    ],
)
def test_damaged_tables_are_refused_in_one_sentence(damage: dict[str, list[object]]) -> None:
    arrays = table_of([0, 1, 2]).to_arrays()
    with pytest.raises(InputError, match="frame table"):
        FrameTable.from_arrays(arrays | {name: np.array(values) for name, values in damage.items()})


def test_a_table_without_a_part_is_refused() -> None:
    arrays = table_of([0, 1, 2]).to_arrays()
    del arrays["corrupt"]
    with pytest.raises(InputError, match="frame table is damaged"):
        FrameTable.from_arrays(arrays)


def test_tables_differ_in_any_part() -> None:
    table = table_of([0, 1, 2])
    assert table == table_of([0, 1, 2])
    assert table != table_of([0, 1, 2], Fraction(1, 25))
    assert table != table_of([0, 1, 3])
    assert table != "a table"


def test_contradictions_are_refused() -> None:
    three, none = np.arange(3), np.zeros(3, dtype=np.bool_)
    with pytest.raises(ValueError, match=r"FrameTable\.key must have shape \(3,\)"):
        FrameTable(Fraction(1, 25), three, three, none[:2], none, 3, complete=True)
    with pytest.raises(ValueError, match="confirmed"):
        FrameTable(Fraction(1, 25), three, three, none, none, 2, complete=True)


def test_the_ledger_compares_known_rows() -> None:
    ledger = FrameLedger(Fraction(1, 25))
    assert ledger.record(0, 10, key=True, corrupt=False)
    assert ledger.record(1, 11, key=False, corrupt=True)
    assert ledger.record(1, 11, key=False, corrupt=True)
    assert not ledger.record(1, 12, key=False, corrupt=True)
    assert not ledger.record(0, 10, key=False, corrupt=False)
    with pytest.raises(ValueError, match="cannot follow"):
        ledger.record(5, 1, key=False, corrupt=False)
    assert ledger.damaged
    assert ledger.key_at_or_before(1) == 0
    assert not ledger.finish(1)
    assert ledger.finish(2)
    assert not ledger.record(2, 12, key=False, corrupt=False), "nothing follows the end"
    table = ledger.table(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_), None)
    assert table.complete
    assert table.stamps.tolist() == [10, 11]
    assert table.corrupt.tolist() == [False, True]


@given(tables(), st.integers(0, 12), st.integers(0, 12))
def test_a_ledger_adopts_rows_that_agree_with_it(table: FrameTable, own: int, other: int) -> None:
    def head(n: int) -> FrameTable:
        confirmed = min(n, table.confirmed)
        return replace(table, confirmed=confirmed, complete=table.complete and confirmed == len(table))

    ledger = FrameLedger(table.time_base, head(own))
    assert ledger.adopt(head(other))
    longest = max((head(own), head(other)), key=lambda one: (one.confirmed, one.complete))
    assert len(ledger) == longest.confirmed
    assert ledger.complete == (head(own).complete or head(other).complete)
    n = longest.confirmed
    found = ledger.table(table.stamps[n:], table.key[n:], None)
    assert (found.stamps == table.stamps).all()
    assert (found.key == table.key).all()
    assert (found.corrupt[:n] == table.corrupt[:n]).all()


@pytest.mark.parametrize("wrong", ["stamps", "key", "corrupt", "shorter"])
def test_a_ledger_refuses_another_files_rows(wrong: str) -> None:
    table = table_of([0, 1, 2, 3])
    other = table_of([0, 1, 2]) if wrong == "shorter" else replace(table, **{wrong: 1 - getattr(table, wrong)})
    ledger = FrameLedger(table.time_base, replace(table, complete=False))
    assert not ledger.adopt(other)
    assert (len(ledger), ledger.complete, ledger.damaged) == (4, False, False)
    assert ledger.adopt(table)
    assert ledger.complete


def test_decoding_does_not_start_at_a_key_frame_with_a_shared_stamp() -> None:
    ledger = FrameLedger(Fraction(1, 1000))
    for k, (stamp, key) in enumerate([(0, True), (5, True), (5, False), (7, False), (8, True), (8, True), (9, True)]):
        ledger.record(k, stamp, key=key, corrupt=False)
    assert [ledger.start_at_or_before(k) for k in range(7)] == [0] * 7, "what follows the last row may share its stamp"
    assert ledger.finish(7)
    assert [ledger.start_at_or_before(k) for k in range(7)] == [*[0] * 6, 6]
    assert [ledger.key_at_or_before(k) for k in range(7)] == [0, 1, 1, 1, 4, 5, 6]
    assert FrameLedger(Fraction(1, 1000)).start_at_or_before(0) is None


def test_a_stamp_repeated_much_later_is_shared_too() -> None:
    ledger = FrameLedger(Fraction(1, 1000))
    for k, stamp in enumerate([0, 6, 3, 6, 4]):
        ledger.record(k, stamp, key=True, corrupt=False)
    assert ledger.finish(5)
    assert [ledger.start_at_or_before(k) for k in range(5)] == [0, 0, 2, 2, 4]
