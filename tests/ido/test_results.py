"""Results as columns and as a file."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from ido.experiments import Results
from ido.results import ResultsError


@pytest.fixture
def results() -> Results:
    rng = np.random.default_rng(0)
    n = 200
    return Results(
        dataset=rng.choice(["bunny", "urban"], n),
        method=rng.choice(["DO", "KCCE (reconstruction), tuned"], n),
        sweep=rng.choice(["noise", "points"], n),
        level=rng.choice([0.0, 0.02, 4000.0], n),
        trial=rng.integers(0, 100, n),
        seed=rng.integers(0, 2**32, n),
        accuracy=rng.uniform(size=n),
        rmse=np.where(rng.uniform(size=n) < 0.1, np.nan, rng.uniform(size=n)),
        rotation=rng.uniform(0, 180, n),
        translation=rng.uniform(size=n),
        seconds=rng.uniform(size=n),
        iterations=rng.integers(0, 1000, n),
        stop=rng.choice(["converged", "failed"], n),
        probability=np.where(rng.uniform(size=n) < 0.5, np.nan, rng.uniform(size=n)),
    )


def test_a_file_gives_back_what_was_saved(results: Results, tmp_path: Path) -> None:
    results.save(tmp_path / "results.npz")
    loaded = Results.load(tmp_path / "results.npz")
    for field in fields(Results):
        saved, read = getattr(results, field.name), getattr(loaded, field.name)
        if saved.dtype.kind == "f" and field.name != "level":
            np.testing.assert_allclose(read, saved, rtol=1e-6)
        else:
            assert (read == saved).all(), field.name


def test_where_keeps_the_entries_with_these_values(results: Results) -> None:
    chosen = results.where(dataset="urban", level=0.02)
    assert len(chosen) == ((results.dataset == "urban") & (results.level == 0.02)).sum() > 0
    assert set(chosen.dataset) == {"urban"}
    assert len(results.where(method="no such")) == 0


def test_among_keeps_the_entries_with_one_of_these_values(results: Results) -> None:
    chosen = results.among(sweep=["noise"], level=[0.0, 4000.0])
    assert len(chosen) == ((results.sweep == "noise") & (results.level != 0.02)).sum() > 0


def test_merged_results_have_each_registration_once_the_first_ones(results: Results) -> None:
    keys = list(zip(results.dataset, results.method, results.sweep, results.level, results.trial, strict=True))
    changed = replace(results, accuracy=results.accuracy + 1)
    merged = Results.merged([results.where(dataset="bunny"), changed])
    assert len(merged) == len(set(keys))
    assert (merged.where(dataset="bunny").accuracy <= 1).all() and (merged.where(dataset="urban").accuracy >= 1).all()
    ours = list(zip(merged.dataset, merged.method, merged.sweep, merged.level, merged.trial, strict=True))
    assert ours == sorted(set(keys))


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut off", b"seed,score\n1,2\n"])
def test_a_foreign_file_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "results.npz"
    with pytest.raises(ResultsError, match="no such file"):
        Results.load(path)
    path.write_bytes(content)
    with pytest.raises(ResultsError, match="results file"):
        Results.load(path)


def test_a_file_without_a_column_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "results.npz", accuracy=np.zeros(3))
    with pytest.raises(ResultsError, match="not a results file"):
        Results.load(tmp_path / "results.npz")


def test_a_save_that_fails_leaves_the_old_file_and_nothing_else(
    results: Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "results.npz"
    results.save(path)
    before = path.read_bytes()

    def full(self: Path, target: Path) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        results.where(dataset="urban").save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
