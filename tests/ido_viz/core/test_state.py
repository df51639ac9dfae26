"""The state of a page: its code goes there and back, and nonsense is refused."""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ido import RANGES, Perturbation
from ido.perturbation import OutlierKind
from ido_viz.core.library import shipped_library
from ido_viz.core.state import FARTHEST, LAST, LONGEST_RUN, BinOrder, State, StateError, decode, encode

LIBRARY = shipped_library()
TYPICAL = State(
    shape="urban",
    perturbation=Perturbation(
        noise=0.037,
        points=1250,
        outliers=170,
        incomplete=0.42,
        rotation=117.0,
        translation=0.81,
        outlier_kind="structured",
        seed=482_913,
    ),
    left="Improved DO",
    right="DO",
    epsilon=0.005,
    iteration=LAST,
    playing=False,
    order="elevation",
    dark=True,
)


@st.composite
def perturbations(draw: st.DrawFn) -> Perturbation:
    values: dict[str, Any] = {
        name: draw(st.integers(int(allowed.low), int(allowed.high)))
        if name in ("points", "outliers")
        else draw(st.floats(allowed.low, allowed.high))
        for name, allowed in RANGES.items()
    }
    return Perturbation(
        **values, outlier_kind=draw(st.sampled_from(get_args(OutlierKind))), seed=draw(st.integers(0, 999_999))
    )


moderate = st.floats(-FARTHEST, FARTHEST) | st.integers(-20, 20)
six_numbers = st.just(()) | st.tuples(*[moderate] * 6)


@st.composite
def states(draw: st.DrawFn) -> State:
    shape = draw(st.sampled_from(list(LIBRARY.subjects)))
    method = st.sampled_from(LIBRARY.methods(shape))
    return State(
        shape=shape,
        perturbation=draw(perturbations()),
        left=draw(method),
        right=draw(method),
        epsilon=draw(st.floats(1e-5, 0.1)),
        max_iterations=draw(st.integers(1, LONGEST_RUN)),
        iteration=draw(st.integers(LAST, LONGEST_RUN)),
        playing=draw(st.booleans()),
        speed=draw(st.integers(1, 60)),
        order=draw(st.sampled_from(get_args(BinOrder))),
        difference=draw(st.booleans()),
        pinned_map=draw(st.integers(0, 30)),
        ghost=draw(st.booleans()),
        start=draw(six_numbers),
        camera=draw(six_numbers),
        replay=draw(st.booleans()),
        handles=draw(st.booleans()),
        dark=draw(st.booleans()),
    )


def code_of(packed: bytes) -> str:
    return "ido1-" + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def code_of_values(values: object) -> str:
    return code_of(zlib.compress(json.dumps(values).encode()))


@given(states())
def test_a_code_gives_its_state_back(state: State):
    assert decode(encode(state)) == state


@given(states(), st.sampled_from(["", " ", "\n", "\t "]), st.sampled_from(["", " ", "\r\n"]))
def test_blanks_around_a_copied_code_do_no_harm(state: State, before: str, after: str):
    assert decode(before + encode(state) + after) == state


@given(states())
def test_a_code_is_one_word_of_plain_characters(state: State):
    assert encode(state).replace("-", "").replace("_", "").isalnum()
    assert encode(state).isascii()


def test_codes_are_short():
    assert len(encode(State())) < 30
    everyday = State(perturbation=Perturbation(noise=0.02, outliers=450, rotation=95.0, seed=31_337), playing=False)
    assert len(encode(everyday)) < 200
    assert len(encode(TYPICAL)) < 400  # nearly everything changed
    by_hand = State(start=(0.1234, -0.5678, 0.9012, 1.2345, -2.0123, 0.4567), camera=(0.1, -0.9, 0.4, 0.0, 0.1, -0.2))
    assert len(encode(by_hand)) < 200


def test_different_states_have_different_codes():
    some = [State(), State(dark=True), State(iteration=1), State(perturbation=Perturbation(seed=1)), TYPICAL]
    assert len({encode(state) for state in some}) == len(some)


@pytest.mark.parametrize(
    "code",
    [
        "",
        "ido1-",
        "hello",
        "ido1-hello",
        "ido1-%%%%",
        "ido1-ж",
        "ido1-A",
        "https://example.org/",
        "<img src=x onerror=alert(1)>",
        "ido0-" + encode(TYPICAL).removeprefix("ido1-"),
        "ido2-" + encode(TYPICAL).removeprefix("ido1-"),
        encode(TYPICAL).removeprefix("ido1-"),
        "IDO1-" + encode(TYPICAL).removeprefix("ido1-"),
        "ido1-" * 10_000,
        "ido1-" + "A" * 1_000_000,
        code_of(b"not compressed"),
        code_of(zlib.compress(b"\xff\xfe not text")),
        code_of(zlib.compress(b"not json")),
        pytest.param(code_of(zlib.compress(b"[" * 9_000)), id="nested too deep"),
    ],
)
def test_foreign_text_is_refused_with_a_message(code: str):
    with pytest.raises(StateError, match=r"\w{4,}"):
        decode(code)


@pytest.mark.parametrize("values", [[], "state", 3, None, True, [["shape", "bunny"]]])
def test_a_code_that_holds_no_state_is_refused(values: object):
    with pytest.raises(StateError, match="state"):
        decode(code_of_values(values))


@given(states(), st.data())
def test_a_cut_code_is_refused(state: State, data: st.DataObject):
    code = encode(state)
    kept = data.draw(st.integers(0, len(code) - 2), label="characters kept")
    with pytest.raises(StateError):
        decode(code[:kept])


@given(states(), st.data())
def test_a_code_with_a_wrong_character_is_refused_or_means_the_same(state: State, data: st.DataObject):
    code = encode(state)
    place = data.draw(st.integers(5, len(code) - 1), label="place")
    wrong = data.draw(st.sampled_from("ABCXYZabcxyz019-_"), label="wrong character")
    try:
        decoded = decode(code[:place] + wrong + code[place + 1 :])
    except StateError:
        return
    assert decoded == state  # the last character carries bits that mean nothing


@pytest.mark.parametrize(
    "values",
    [
        {"shape": 3},
        {"shape": []},
        {"order": "random"},
        {"order": []},
        {"epsilon": 0},
        {"epsilon": -0.005},
        {"epsilon": float("nan")},
        {"epsilon": float("inf")},
        {"epsilon": "small"},
        {"epsilon": None},
        {"max_iterations": 0},
        {"max_iterations": 10**9},
        {"max_iterations": 10.5},
        {"iteration": -2},
        {"iteration": 10**9},
        {"iteration": 1.5},
        {"iteration": "last"},
        {"speed": 0},
        {"speed": 999},
        {"speed": 1.5},
        {"pinned_map": -1},
        {"pinned_map": 10**9},
        {"pinned_map": 1.5},
        {"playing": "yes"},
        {"difference": 2},
        {"ghost": []},
        {"dark": "no"},
        {"left": 3},
        {"right": []},
        {"colour": "red"},
        *[
            {name: numbers}
            for name in ("start", "camera")
            for numbers in (
                [0.0] * 5,
                [0.0] * 7,
                [0.0] * 5 + [float("nan")],
                [0.0] * 5 + [float("inf")],
                [0.0] * 5 + [20.1],
                [0.0] * 5 + [-1000],
                [0.0] * 5 + [10**400],
                [0.0] * 5 + ["0.0"],
                [0.0] * 5 + [True],
                [0.0] * 5 + [None],
                [0.0] * 5 + [[0.0]],
                "abcdef",
                7,
                None,
                {"x": 1, "y": 2},
            )
        ],
        {"perturbation": []},
        {"perturbation": {"noise": -0.1}},
        {"perturbation": {"noise": float("nan")}},
        {"perturbation": {"noise": 10**400}},
        {"perturbation": {"noise": "loud"}},
        {"perturbation": {"points": 0}},
        {"perturbation": {"points": 10.5}},
        {"perturbation": {"points": 10**9}},
        {"perturbation": {"rotation": 181}},
        {"perturbation": {"incomplete": 1}},
        {"perturbation": {"seed": -1}},
        {"perturbation": {"seed": 0.5}},
        {"perturbation": {"seed": 10**300}},
        {"perturbation": {"outlier_kind": "purple"}},
        {"perturbation": {"outlier_kind": []}},
        {"perturbation": {"gravity": 9.81}},
    ],
    ids=lambda values: json.dumps(values)[:60],
)
def test_a_code_with_values_out_of_range_is_refused(values: dict[str, Any]):
    with pytest.raises(StateError):
        decode(code_of_values(values))


def test_a_huge_text_packed_small_is_refused_without_unpacking_it():
    bomb = zlib.compress(b'{"order":"' + b" " * 300_000_000, level=9)
    assert len(bomb) < 1_000_000
    with pytest.raises(StateError):
        decode(code_of(bomb))


@given(st.text())
def test_no_text_does_worse_than_being_refused(text: str):
    for code in (text, "ido1-" + text, code_of(zlib.compress(text.encode("utf-8", "surrogatepass")))):
        with pytest.raises(StateError):
            decode(code)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(), lambda inner: st.lists(inner), max_leaves=3
)


@given(
    st.dictionaries(st.sampled_from([*State.__slots__, "other"]), json_values),
    st.dictionaries(st.sampled_from([*Perturbation.__slots__, "other"]), json_values),
)
def test_any_values_make_a_usable_state_or_are_refused(values: dict[str, Any], perturbation: dict[str, Any]):
    try:
        state = decode(code_of_values({**values, "perturbation": perturbation}))
    except StateError:
        return
    for name in ("max_iterations", "iteration", "speed", "pinned_map"):
        assert isinstance(getattr(state, name), int), name
    for name in ("playing", "difference", "ghost", "dark"):
        assert isinstance(getattr(state, name), bool), name
    for name in ("shape", "left", "right"):
        assert isinstance(getattr(state, name), str), name
    for name in ("start", "camera"):
        assert len(getattr(state, name)) in (0, 6), name
    assert decode(encode(state)) == state


@pytest.mark.parametrize(
    "values",
    [
        {"order": "random"},
        {"epsilon": 0.0},
        {"epsilon": float("nan")},
        {"max_iterations": 0},
        {"max_iterations": LONGEST_RUN + 1},
        {"iteration": -2},
        {"speed": 0},
        {"speed": 61},
        {"pinned_map": -1},
        {"start": (0.0,) * 5},
        {"start": (0.0, 0.0, 0.0, 0.0, 0.0, float("nan"))},
        {"start": [0.0] * 6},
        {"start": ("0",) * 6},
        {"camera": (0.0, -21.0, 0.0, 0.0, 0.0, 0.0)},
        {"camera": (1.0,)},
    ],
    ids=str,
)
def test_a_state_refuses_nonsense_and_names_it(values: dict[str, Any]):
    (wrong,) = values
    with pytest.raises(StateError, match=wrong):
        State(**values)


@pytest.mark.parametrize(
    "state",
    [
        State(shape="teapot"),
        State(left="ICP"),
        State(right="<b>"),
        State(shape="urban", right="Improved DO (as printed)"),
    ],
    ids=lambda state: f"{state.shape}, {state.left}, {state.right}",
)
def test_the_library_refuses_what_it_does_not_hold(state: State):
    with pytest.raises(StateError):
        LIBRARY.checked(state)


@given(states())
def test_the_library_takes_what_it_holds(state: State):
    assert LIBRARY.checked(state) == state


def test_another_shape_brings_the_outliers_and_methods_that_suit_it():
    bunny = State(perturbation=Perturbation(noise=0.01, seed=5), left="Improved DO (as printed)")
    city = LIBRARY.at_shape(bunny, "urban")
    assert LIBRARY.checked(city) == city
    assert (city.shape, city.right, city.perturbation.outlier_kind) == ("urban", "Improved DO", "structured")
    assert (city.perturbation.noise, city.perturbation.seed) == (0.01, 5)
    assert LIBRARY.at_shape(city, "bunny").perturbation.outlier_kind == "uniform"
