"""Every parameter is documented, bounded and reachable by its leaf name."""

from __future__ import annotations

from collections import Counter

import pytest

from tsr_engine.errors import UsageError
from tsr_engine.params import PRESETS, Params
from tsr_engine.params.parameter_table import parameter_rows

NAMES = list(Params.names())


def test_leaf_names_are_unique_over_all_sections() -> None:
    counts = Counter(leaf for _, leaf in NAMES)
    assert [leaf for leaf, n in counts.items() if n > 1] == []


@pytest.mark.parametrize(("section", "leaf"), NAMES)
def test_every_parameter_has_a_description(section: str, leaf: str) -> None:
    field = type(getattr(Params(), section)).model_fields[leaf]
    assert field.description
    assert len(field.description) >= 8


@pytest.mark.parametrize(("section", "leaf"), NAMES)
def test_nan_is_refused_for_every_number(section: str, leaf: str) -> None:
    if not isinstance(getattr(getattr(Params(), section), leaf), float):
        return
    with pytest.raises(UsageError, match=leaf):
        Params().with_settings([(leaf, "nan")])


@pytest.mark.parametrize(("section", "leaf"), NAMES)
def test_true_and_false_are_not_numbers(section: str, leaf: str) -> None:
    if isinstance(getattr(getattr(Params(), section), leaf), bool):
        changed = Params().with_settings([(leaf, True)])
        assert getattr(getattr(changed, section), leaf) is True
        return
    for value in (True, False, [True], (0.5, True)):
        with pytest.raises(UsageError, match=rf"{section}.{leaf}: must not be true or false"):
            Params().with_settings([(leaf, value)])


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_presets_name_real_parameters_with_allowed_values(preset: str) -> None:
    params = Params.preset(preset)
    for name, value in PRESETS[preset].items():
        section = next(s for s, leaf in NAMES if leaf == name)
        assert getattr(getattr(params, section), name) == value


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("1.05", (1.05,)), ("0.9, 1", (0.9, 1.0)), ("1,", (1.0,)), ("[0.93, 1.0]", (0.93, 1.0)), ("[1.0]", (1.0,))],
)
def test_a_list_may_have_one_or_more_values(typed: str, meant: tuple[float, ...]) -> None:
    assert Params().with_settings([("search_scales", typed)]).online.search_scales == meant


def test_the_list_of_the_command_line_is_complete() -> None:
    assert [(row["section"], row["name"]) for row in parameter_rows()] == NAMES


def test_numbers_say_their_range() -> None:
    unbounded = [
        row["name"]
        for row in parameter_rows()
        if isinstance(row["default"], int | float) and not isinstance(row["default"], bool) and not row["range"]
    ]
    # Scores of the detector have no natural limits.
    assert all("score" in name for name in unbounded), unbounded
