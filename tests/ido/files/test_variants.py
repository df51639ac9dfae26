"""Every variant of a file that the documents tell of is read as it is meant, or refused with the reason."""

from __future__ import annotations

import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest
from cloud_files import POINTS, VARIANTS, Variant

from ido import CloudError, CloudWarning, load_cloud

ROOT = Path(__file__).parents[3]
READ = [variant for variant in VARIANTS if not variant.refused]
REFUSED = [variant for variant in VARIANTS if variant.refused]


def name_of(variant: Variant) -> str:
    return variant.name


@pytest.mark.parametrize("variant", READ, ids=name_of)
def test_it_is_read_as_it_is_meant_and_what_is_left_out_is_told(variant: Variant, tmp_path: Path):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", CloudWarning)
        points = load_cloud(variant.write(tmp_path))
    np.testing.assert_allclose(points, POINTS, rtol=0, atol=1e-4)
    notes = [str(warning.message) for warning in told]
    assert len(notes) == bool(variant.noted)
    assert all(variant.noted in note and variant.name in note for note in notes)


@pytest.mark.parametrize("variant", REFUSED, ids=name_of)
def test_it_is_refused_by_name_with_the_reason_and_without_much_memory(variant: Variant, tmp_path: Path):
    path = variant.write(tmp_path)
    tracemalloc.start()
    with pytest.raises(CloudError) as refused:
        load_cloud(path)
    assert str(refused.value).startswith(f"{variant.name}: ")
    assert variant.refused in str(refused.value)
    assert tracemalloc.get_traced_memory()[1] < 20e6  # claims are of gigabytes
    tracemalloc.stop()


def test_the_document_has_every_variant_and_what_becomes_of_it():
    rows = [
        f"| `{variant.name}` | {variant.what} | {f'refused: *{variant.refused}*' if variant.refused else 'read'}"
        f"{f', and told: *{variant.noted}*' if variant.noted else ''} |"
        for variant in VARIANTS
    ]
    assert "\n".join(rows) in (ROOT / "assets" / "docs" / "files.md").read_text(encoding="utf-8")


def test_names_are_unique():
    assert len({variant.name for variant in VARIANTS}) == len(VARIANTS)
