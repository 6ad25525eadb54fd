"""No scenario file, however odd, does anything but load or be refused with a ScenarioError."""

from __future__ import annotations

import contextlib
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from vulnus.core.errors import ScenarioError
from vulnus.scenario import scenario_from_text
from vulnus.scenario.complaints import all_keys
from vulnus.scenario.config import ScenarioConfig
from vulnus.scenario.toml_text import value_as_toml

KEYS = sorted(all_keys(ScenarioConfig))
VALUES = st.recursive(
    st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
    | st.sampled_from(["auto", "distal", "builtin_leg", "anterior_tibial", "llvm"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text("abc", min_size=1), inner),
    max_leaves=6,
)
RAW = st.sampled_from(["nan", "inf", "-inf", "1979-05-27", "07:32:00", "0x10", "1e999", "[nan]"])


def accepted_or_refused(text: str) -> Any:
    with contextlib.suppress(ScenarioError):
        scenario = scenario_from_text(text, file="mine.toml")
        assert scenario_from_text(scenario.text, file="again") == scenario
        return scenario
    return None


@settings(derandomize=True, max_examples=150, deadline=None)
@given(text=st.text(st.characters(exclude_categories=["Cs"]), max_size=200))
def test_any_text(text: str) -> None:
    accepted_or_refused(text)


@settings(derandomize=True, max_examples=250, deadline=None)
@given(
    pairs=st.dictionaries(
        st.sampled_from(KEYS) | st.text("abc_.", min_size=1, max_size=8),
        VALUES.map(value_as_toml) | RAW,
        min_size=1,
        max_size=4,
    )
)
def test_any_value_at_any_key(pairs: dict[str, str]) -> None:
    accepted_or_refused("\n".join(f"{key} = {value}" for key, value in pairs.items()))


@settings(derandomize=True, max_examples=200, deadline=None)
@given(key=st.sampled_from(KEYS), size=st.floats(1e-3, 1e4))
def test_any_number_at_any_key_survives_its_own_text(key: str, size: float) -> None:
    accepted_or_refused(f"{key} = {size!r}")
    accepted_or_refused(f"{key} = {int(size)}")


def test_a_change_is_seen() -> None:
    first = accepted_or_refused("injury.projectile.diameter_mm = 9.0")
    assert first != accepted_or_refused("injury.projectile.diameter_mm = 9.000000001")
