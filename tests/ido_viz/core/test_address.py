"""The fragment of an address."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ido import Perturbation
from ido_viz.core.address import LONGEST_FRAGMENT, Fragment, fragment_of, opens_elsewhere, read_fragment
from ido_viz.core.state import BinOrder, State, StateError, decode

STATES = st.builds(
    State,
    perturbation=st.builds(Perturbation, rotation=st.floats(0, 180), seed=st.integers(0, 9999)),
    playing=st.booleans(),
    iteration=st.integers(-1, 5000),
    question=st.text(max_size=100),
    order=st.sampled_from(BinOrder.__args__),
)


@given(STATES, st.sampled_from(["", "histogram/3"]))
def test_a_fragment_leads_back_to_its_page_which_begins_anew_if_it_plays(state: State, step: str):
    text = fragment_of(state, step)
    assert text.isascii() and len(text) <= LONGEST_FRAGMENT
    read = read_fragment(text)
    assert read.step == step
    assert decode(read.code) == (replace(state, iteration=0) if state.playing else state)


def test_a_playing_page_keeps_its_fragment_from_one_iteration_to_the_next():
    fragments = {fragment_of(State(iteration=k), "") for k in range(5)}
    assert len(fragments) == 1
    assert fragment_of(State(playing=False), "") not in fragments


@given(st.text(max_size=200), st.text(max_size=100))
def test_whatever_stands_in_a_fragment_survives_it(code: str, step: str):
    fragment = Fragment(code.strip("\x00"), step)
    assert read_fragment(str(fragment)) == fragment


@pytest.mark.parametrize(
    "text", ["ido1-abc", "state", "code=1", "state=a&lesson=b&more=c", "state=%ff", "state=a&state"]
)
def test_what_is_no_fragment_is_said(text: str):
    with pytest.raises(StateError, match="after # stands state=CODE or lesson=NAME"):
        read_fragment(text)


def test_a_fragment_has_an_end():
    with pytest.raises(StateError, match="more than 2000 characters"):
        read_fragment("state=" + "a" * LONGEST_FRAGMENT)


@pytest.mark.parametrize(
    ("link", "elsewhere"),
    [
        ("http://127.0.0.1:8080/#state=a", False),
        ("http://localhost:8080/", False),
        ("http://[::1]:8080/", False),
        ("http://192.168.1.5:8080/?token=a", True),
        ("https://example.org/", True),
    ],
)
def test_links_of_this_machine_alone_are_known(link: str, elsewhere: bool):
    assert opens_elsewhere(link) == elsewhere
