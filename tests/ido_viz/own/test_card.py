"""Quality cards: what they say is what an own count says, and damaged ones are as none."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ido import Cloud, Perturbation, perturb, register, score, shipped_maps
from ido.experiments import LEVELS, level_scene
from ido_viz.own import card as card_module
from ido_viz.own.card import Card
from ido_viz.own.kept_folder import card_html, question


def test_a_card_holds_the_mean_accuracy_at_each_level(bunny: Cloud, monkeypatch: pytest.MonkeyPatch):
    """Of maps that find a pose, or one that stays: others wander, each processor's rounding to another end."""
    monkeypatch.setattr(card_module, "SCENES", 2)
    monkeypatch.setattr(card_module, "LEVELS", {"rotation": LEVELS["rotation"]})
    maps = shipped_maps("bunny", "triple-binary")
    card = Card.of(bunny, {"Improved DO": maps})
    rows = []
    for level in LEVELS["rotation"]:
        scenes = [
            perturb(bunny, level_scene(Perturbation(), "rotation", level, trial, 2, 1_000_000)) for trial in range(2)
        ]
        ends = [register(maps, scene.points).T_model_scene[-1] for scene in scenes]
        rows.append(np.mean([score(scene, T).accuracy for scene, T in zip(scenes, ends, strict=True)]))
    np.testing.assert_allclose(card.rows["Improved DO"]["rotation"], rows, atol=0.01)
    assert rows[0] > 0.99 and rows[-1] < 0.5


def made() -> Card:
    return Card({"DO": {name: tuple(i / 10 for i in range(len(levels))) for name, levels in LEVELS.items()}})


def test_a_card_comes_back_as_it_was(tmp_path: Path):
    made().save(tmp_path / "card.json")
    assert Card.load(tmp_path / "card.json") == made()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"PointAcc": {}}',
        '{"PointAcc": {"DO": {}}}',
        '{"PointAcc": {"DO": 3}}',
        json.dumps({"PointAcc": {"DO": {name: [0.5] for name in LEVELS}}}),
        json.dumps({"PointAcc": {"DO": {name: ["x"] * len(levels) for name, levels in LEVELS.items()}}}),
        json.dumps({"PointAcc": {"DO": {name: [float("nan")] * len(levels) for name, levels in LEVELS.items()}}}),
    ],
)
def test_a_card_that_is_not_as_it_should_be_is_made_anew(tmp_path: Path, text: str):
    (tmp_path / "card.json").write_text(text)
    assert Card.load(tmp_path / "card.json") is None
    assert Card.load(tmp_path / "none.json") is None


def test_a_card_shows_every_level_beside_its_accuracy():
    text = card_html("<b>name</b>", made())
    assert "<td" in text and "DO" in text
    for levels in LEVELS.values():
        assert " ".join(f"{level:g}" for level in levels) in text
    assert "0.00 0.10 0.20 0.30 0.40 0.50 0.60" in text


def test_a_name_is_text_where_there_is_no_card_yet():
    assert "&lt;b&gt;name" in card_html("<b>name</b>", None)


@pytest.mark.parametrize(("others", "words"), [(0, "No other page"), (1, "1 other page</b>"), (3, "3 other pages</b>")])
def test_deleting_says_who_else_is_there(others: int, words: str):
    assert words in question(others)
