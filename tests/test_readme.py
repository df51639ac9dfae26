"""The README's Python examples run as they are printed."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
EXAMPLES = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)


def test_there_are_examples():
    assert len(EXAMPLES) == 2


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_an_example_runs(number: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    monkeypatch.chdir(ROOT)
    exec(compile(EXAMPLES[number], f"README example {number}", "exec"), {"__name__": "example"})
    printed = capsys.readouterr().out
    if number == 0:
        assert re.search(r"(converged|iteration limit) \d", printed)
    else:
        errors = [float(value) for value in printed.strip("[] \n").split()]
        assert len(errors) == 4 and sorted(errors, reverse=True) == errors
