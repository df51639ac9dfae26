"""How long trainings take: plans keep to their time, and what is measured grows as the work does."""

from __future__ import annotations

import pytest

from ido import Cloud, Model
from ido_viz.own import plans
from ido_viz.own.draft import Draft
from ido_viz.own.plans import FEWEST_SCENES, PLANS, Cost, in_words, measured_cost, time_left
from ido_viz.own.train_folder import estimate_text

FAST, USUAL, SLOW = Cost(1e-6, 1e-6, 1e-4), Cost(4e-4, 3e-4, 0.5), Cost(1e-2, 1e-2, 10.0)


@pytest.mark.parametrize("name", ["quick", "standard"])
def test_a_plan_uses_its_time_and_does_not_exceed_it(name: str):
    plan = PLANS[name]
    assert plan.limit is not None
    settings = plan.settings(USUAL, 45.0, 0.2)
    assert 0.5 * plan.limit < USUAL.seconds(settings) <= 0.8 * plan.limit
    assert (settings.rotation, settings.translation, settings.maps) == (45.0, 0.2, plan.maps)


def test_the_fewer_scenes_the_stronger_is_the_first_ridge():
    quick, slow, paper = (
        PLANS[n].settings(c, 90.0, 0.3) for n, c in (("quick", USUAL), ("quick", SLOW), ("paper", USUAL))
    )
    for settings in (quick, slow, paper):
        assert settings.first_ridge is not None
        assert settings.first_ridge * settings.samples == pytest.approx(2e-4 * 30_000)
        assert settings.ridge == 2e-4


def test_plans_have_their_bounds_on_any_machine():
    for plan in PLANS.values():
        assert plan.settings(FAST, 90.0, 0.3).samples == plan.most_scenes
        assert plan.settings(SLOW, 90.0, 0.3).samples == (plan.most_scenes if plan.limit is None else FEWEST_SCENES)
    paper = PLANS["paper"].settings(SLOW, 90.0, 0.3)
    assert (paper.samples, paper.maps) == (30_000, 30)


def test_regressions_are_measured_as_large_as_they_are_solved(bunny: Cloud, monkeypatch: pytest.MonkeyPatch):
    sizes: set[int] = set()
    really = plans.solve
    monkeypatch.setattr(plans, "solve", lambda h, *rest: sizes.add(h.shape[1]) or really(h, *rest))
    model = Model.of(bunny, 100)
    measured_cost(bunny, model)
    assert sizes == {200, 200 + 2 * 101}  # see `ido.folding`: an angle block has M + 1 numbers in its 2 M bins


def test_what_is_measured_is_positive_and_more_scenes_take_longer(tiny_draft: Draft):
    cost = measured_cost(tiny_draft.cloud, tiny_draft.model)
    assert cost.scene > 0 and cost.scene_in_map > 0 and cost.map_itself >= 0
    quick, paper = (PLANS[name].settings(cost, 90.0, 0.3) for name in ("quick", "paper"))
    assert 0 < cost.seconds(quick) < cost.seconds(paper)


def test_the_time_left_starts_as_expected_comes_to_what_is_measured_and_ends_with_nothing():
    assert time_left(20.0, [100.0], 10) == pytest.approx(20.0)
    evenly = [100.0 + 4.0 * k for k in range(11)]
    left = [time_left(20.0, evenly[: k + 1], 10) for k in range(11)]
    assert left[5] == pytest.approx(5 * (2 + 20) / 6) and left[10] == 0.0
    assert left[8] == pytest.approx(8.0, rel=0.1)


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.2, "1 s"), (7.4, "7 s"), (23, "25 s"), (99, "100 s"), (290, "5 min")]
)
def test_times_are_said_no_more_exactly_than_they_are_known(seconds: float, words: str):
    assert in_words(seconds) == words


def test_a_training_that_will_not_be_done_in_its_time_says_so_beforehand():
    settings = PLANS["quick"].settings(SLOW, 90.0, 0.3)
    late = estimate_text(settings, SLOW.seconds(settings), 30.0)
    assert SLOW.seconds(settings) > 30 and "<b>30 s</b> it ends" in late
    for seconds, limit in ((29.0, 30.0), (500.0, None)):
        assert "ends" not in estimate_text(settings, seconds, limit)
