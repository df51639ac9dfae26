"""The documents: equations are numbered and named in the code, links lead somewhere, tables are what the code says."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

import ido
from ido import HISTOGRAMS, poses
from ido.attribution import Attribution
from ido.baselines.gaussian import best_pose
from ido.blocks import Question
from ido.clouds import Cloud, Frame
from ido.kernels import left_jacobian
from ido.methods import BASELINES, LEARNED
from ido.training import solve

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "assets" / "docs"
METHOD = (DOCS / "method.md").read_text(encoding="utf-8")
MARKDOWN = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((ROOT / "assets").rglob("*.md")),
]
EQUATIONS = [int(number) for number in re.findall(r"\\tag\{(\d+)\}", METHOD)]
REFERENCE = re.compile(r"docs/method\.md,\s+Eq\.\s+((?:\d+(?:,\s+|\s+and\s+)?)+)")
"""``docs/method.md, Eq. 5``, ``Eq. 5 and 6`` or ``Eq. 5, 6 and 12``."""


def sources() -> list[Path]:
    return sorted(path for package in ("ido", "ido_viz") for path in (ROOT / package).rglob("*.py"))


def docstrings(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            yield ast.get_docstring(node) or ""


def numbers(text: str) -> list[int]:
    """Of the equations that a text names."""
    return [int(number) for found in REFERENCE.findall(text) for number in re.findall(r"\d+", found)]


def prose(text: str) -> str:
    """A document without its code."""
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)


def headings(text: str) -> list[str]:
    return re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE)


def anchor(heading: str) -> str:
    """What a heading is called in a link."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


@pytest.fixture(scope="module")
def make_docs() -> ModuleType:
    spec = spec_from_file_location("make_docs", ROOT / "assets" / "scripts" / "make_docs.py")
    assert spec and spec.loader
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# equations


def test_equations_are_numbered_in_order_without_gaps():
    assert list(range(1, len(EQUATIONS) + 1)) == EQUATIONS
    assert len(re.findall(r"^\$\$ .* \$\$$", METHOD, re.MULTILINE)) == len(EQUATIONS), "each on a line of its own"


def test_every_equation_that_a_text_names_exists_and_the_references_are_all_of_one_form():
    for path in sources():
        text = path.read_text(encoding="utf-8")
        assert set(numbers(text)) <= set(EQUATIONS), path
        assert text.count("method.md, Eq.") == len(REFERENCE.findall(text)), path
        assert not re.search(r"\bEq\. eq_|paper, Eq\.", text), path
    for path in MARKDOWN:
        named = re.findall(r"Eq\. (\d+)(?: and (\d+))?", path.read_text(encoding="utf-8"))
        assert {int(number) for pair in named for number in pair if number} <= set(EQUATIONS), path


def test_every_equation_is_named_by_a_docstring():
    named = {number for path in sources() for text in docstrings(path) for number in numbers(text)}
    assert named == set(EQUATIONS)


def test_every_step_from_any_start_is_named_by_what_does_it_and_every_source_by_a_step():
    text = (DOCS / "global.md").read_text(encoding="utf-8")
    steps, listed = text.split("## Sources")
    equations = {int(n) for found in re.findall(r"\(Eq\. (\d+(?: and \d+)?)\)", steps) for n in found.split(" and ")}
    named: set[int] = set()
    for path in sources():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
                for found in re.findall(r"docs/global\.md,\s+Eq\. (\d+(?: and \d+)?)", ast.get_docstring(node) or ""):
                    named |= {int(number) for number in found.split(" and ")}
    assert named == equations == set(range(1, len(equations) + 1))
    cited = {int(n) for found in re.findall(r"\[(\d(?:, \d)*)\]", steps) for n in found.split(", ")}
    assert cited == {int(number) for number in re.findall(r"^(\d+)\. ", listed, re.MULTILINE)}


def test_sections_that_the_code_names_exist():
    for path in sources():
        for section in re.findall(r'docs/method\.md, "(.*?)"', path.read_text(encoding="utf-8")):
            assert section in headings(METHOD), path


@pytest.mark.parametrize(
    ("thing", "expected"),
    [
        (poses.transform, {1}),
        (poses.exp, {2}),
        (poses.log, {2}),
        (Frame, {3}),
        (Cloud.of, {3}),
        (ido.perturb, {4}),
        (ido.BlockHistogram, {9}),
        (ido.AsPrinted, {10}),
        (ido.train, {13, 14}),
        (solve, {15}),
        (ido.register, {13, 16}),
        (ido.register_batch, {13, 16}),
        (ido.score, {17, 18}),
        (Attribution.along, {19}),
        (left_jacobian, {2}),
        (best_pose, {25}),
    ],
)
def test_what_implements_an_equation_names_it(thing: object, expected: set[int]):
    assert set(numbers(thing.__doc__ or "")) == expected


def test_every_block_and_every_baseline_names_its_equation():
    blocks = {type(block) for histogram in HISTOGRAMS.values() for block in histogram.blocks}
    assert all(numbers(block.__doc__ or "") for block in blocks if issubclass(block, Question))
    for name, baseline in BASELINES.items():
        assert numbers(type(baseline).__doc__ or "") or name == "Did nothing", name


def test_formulas_hold_nothing_that_markdown_would_change():
    formulas = re.findall(r"\$\$.+?\$\$|\$[^$\n]+\$", METHOD)
    assert len(formulas) > len(EQUATIONS)
    for formula in formulas:
        assert not re.search(r"\\[^A-Za-z]|[<>*]", formula), formula
        assert formula.count("{") == formula.count("}"), formula
    for line in METHOD.splitlines():
        assert line.count("$") % 2 == 0, line


# links


def test_links_lead_to_files_and_headings_that_exist():
    checked = 0
    for path in MARKDOWN:
        for target in re.findall(r"\]\(([^)\s]+)\)", prose(path.read_text(encoding="utf-8"))):
            if re.match(r"https?:|mailto:", target) or path.parent.name in ("lessons", "derivations"):
                continue  # those two are about the links of other files
            file, _, heading = target.partition("#")
            there = (path.parent / file).resolve() if file else path
            assert there.exists() and there.is_relative_to(ROOT), f"{path.name}: {target}"
            if heading:
                assert heading in map(anchor, headings(there.read_text(encoding="utf-8"))), f"{path.name}: {target}"
            checked += 1
    assert checked > 30


def test_files_that_the_documents_name_exist():
    for path in (ROOT / "CONTRIBUTING.md", *DOCS.glob("*.md"), *(ROOT / "assets").glob("*/README.md")):
        for name in re.findall(r"`((?:ido|ido_viz|assets|tests)/[\w./-]+)`", path.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{path.name}: {name}"


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 160


def test_the_version_is_the_same_everywhere():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\n## {version}\n" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_all_documents_can_be_reached_from_the_readme():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for path in DOCS.glob("*.md"):
        assert f"(assets/docs/{path.name})" in text


# what the script writes


def test_the_documents_are_what_the_script_would_write(make_docs: ModuleType):
    found: list[str] = []
    for path in sorted(DOCS.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        assert make_docs.written(text) == text, f"{path.name}: run assets/scripts/make_docs.py"
        found += re.findall(r"<!-- begin (\S+) -->", text)
    assert sorted(found) == sorted(make_docs.PARTS), "each part stands in one document"


def test_the_table_of_blocks_has_every_block_and_learned_method(make_docs: ModuleType):
    rows = [[cell.strip() for cell in row.strip("|").split(" | ")] for row in make_docs.blocks().splitlines()[2:]]
    names = {block.name for histogram in HISTOGRAMS.values() for block in histogram.blocks}
    assert {row[1] for row in rows} == names and len(rows) == len(names)
    near = next(row for row in rows if row[1] == "near / far")
    assert near[0] == "`NearOrFar`" and near[3] == "Improved DO (near / far)"
    assert "exp(" in near[4] and near[4].endswith(".")
    front = next(row for row in rows if row[1] == "front / back")
    assert front[3].split(", ") == list(LEARNED)


def test_a_part_that_nobody_makes_is_refused(make_docs: ModuleType):
    with pytest.raises(KeyError):
        make_docs.written("<!-- begin nothing -->\n<!-- end nothing -->")


def test_text_beside_the_parts_stays(make_docs: ModuleType):
    text = "before\n<!-- begin levels -->\nold\n<!-- end levels -->\nafter\n"
    lines = make_docs.written(text).splitlines()
    assert (lines[0], lines[-1]) == ("before", "after") and "old" not in lines
