"""The README's Python examples run as they are printed."""

import re
from pathlib import Path

import pytest

from ido_viz.export import run_npz
from ido_viz.library import shipped_library
from ido_viz.run import compute
from ido_viz.state import State

ROOT = Path(__file__).parent.parent
EXAMPLES = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)


def test_there_are_examples():
    assert len(EXAMPLES) == 3


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_an_example_runs(
    number: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
):
    monkeypatch.chdir(ROOT)
    if "load_run" in EXAMPLES[number]:
        monkeypatch.chdir(tmp_path)
        Path("ido-bunny-0.npz").write_bytes(run_npz(compute(State(), shipped_library()), State()))
    exec(compile(EXAMPLES[number], f"README example {number}", "exec"), {"__name__": "example"})
    printed = capsys.readouterr().out
    if number == 0:
        assert re.search(r"(converged|iteration limit) \d", printed)
    elif number == 2:
        assert re.fullmatch(r"DO converged \S+ \(\d+, 1028\)\nImproved DO converged \S+ \(\d+, 3084\)\n", printed)
    else:
        errors = [float(value) for value in printed.strip("[] \n").split()]
        assert len(errors) == 4 and sorted(errors, reverse=True) == errors
