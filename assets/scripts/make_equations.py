"""Typeset the equations of the derivations: `python assets/scripts/make_equations.py` (needs Node.js with npm).

It installs MathJax, in one version, into a temporary folder, and writes `equations/NAME.svg` for each equation in
`derivations`: shapes alone, black, no fonts, with the LaTeX source as the title. The same sources
give the same bytes. Files that no equation uses any more are removed.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

from ido_viz.teach.derivations import derivations, equations_of

MATHJAX = "mathjax-full@3.2.2"
SVG = "http://www.w3.org/2000/svg"
UNITS = 1000
"""Of a drawing, to an em."""

_KEPT = {"viewBox", "d", "transform", "x", "y", "width", "height"}
_DRAWN = {"svg", "g", "path", "rect"}


def main() -> None:
    """Write all equations."""
    folder = Path(__file__).parents[1] / "equations"
    folder.mkdir(exist_ok=True)
    drawings = typeset({equation.name: equation.tex for equation in equations_of(derivations())})
    for old in folder.glob("*.svg"):
        old.unlink()
    for name, drawing in drawings.items():
        (folder / f"{name}.svg").write_text(drawing, encoding="utf-8", newline="\n")
    files = list(folder.iterdir())
    print(f"{len(files)} equations, {sum(file.stat().st_size for file in files) / 1000:.0f} kB")


def typeset(sources: dict[str, str]) -> dict[str, str]:
    """SVG of equations, by their names."""
    npm, node = shutil.which("npm"), shutil.which("node")
    if npm is None or node is None:
        raise SystemExit("Node.js and npm are needed to typeset equations")
    with tempfile.TemporaryDirectory() as place:
        install = [npm, "install", "--silent", "--no-audit", "--no-fund", "--prefix", place, MATHJAX]
        subprocess.run(install, check=True)
        script = Path(__file__).with_suffix(".mjs").resolve()
        done = subprocess.run(
            [node, str(script)], cwd=place, input=json.dumps(sources), capture_output=True, encoding="utf-8"
        )
    if done.returncode:
        raise SystemExit(done.stderr)
    return {name: cleaned(drawing, sources[name]) for name, drawing in json.loads(done.stdout).items()}


def cleaned(drawing: str, tex: str) -> str:
    """A drawing of MathJax's with nothing but black shapes and the source that it was made from."""
    ET.register_namespace("", SVG)
    root = ET.fromstring(drawing)
    for element in root.iter():
        kind = element.tag.removeprefix(f"{{{SVG}}}")
        if kind not in _DRAWN:
            raise SystemExit(f"{tex}: <{kind}> is not expected in a drawing")
        for name in set(element.attrib) - _KEPT:
            del element.attrib[name]
    _share_shapes(root)
    _, _, width, height = (float(number) for number in root.attrib["viewBox"].split())
    root.set("width", f"{width / UNITS:.3f}em")
    root.set("height", f"{height / UNITS:.3f}em")
    title = ET.Element(f"{{{SVG}}}title")
    title.text = tex
    root.insert(0, title)
    return ET.tostring(root, encoding="unicode") + "\n"


def _share_shapes(root: ET.Element) -> None:
    """Keep each letter's shape once, however often the letter is used."""
    shapes = ET.Element(f"{{{SVG}}}defs")
    names: dict[str, str] = {}
    for letter in list(root.iter(f"{{{SVG}}}path")):
        shape = letter.attrib.pop("d")
        if shape not in names:
            names[shape] = f"s{len(names)}"
            ET.SubElement(shapes, f"{{{SVG}}}path", {"id": names[shape], "d": shape})
        letter.tag = f"{{{SVG}}}use"
        letter.set("href", f"#{names[shape]}")
    root.insert(0, shapes)


if __name__ == "__main__":
    main()
