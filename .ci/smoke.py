"""Registers a shipped cloud and starts the page, in the current folder: `smoke.py ENVIRONMENT`.

Where the current folder holds the source, Python is started so that this goes before what the environment has
installed, else the environment's commands are.
"""

import json
import signal
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path

FIND = """
import ido
from ido_viz.teach.derivations import derivations
from ido_viz.teach.lessons import lessons
from ido_viz.teach.presets import presets
print(ido.__file__, len(lessons()), len(presets()), len(derivations()))
"""

signal.signal(signal.SIGINT, signal.default_int_handler)  # a script in the background ignores it, and so would the page
environment = Path(sys.argv[1])
python = str(environment / "bin" / "python")
if inside := Path("ido").is_dir():
    ido, ido_viz = [python, "-c", "from ido.cli import main; exit(main())"], [python, "-m", "ido_viz"]
else:
    ido, ido_viz = [str(environment / "bin" / "ido")], [str(environment / "bin" / "ido-viz")]


def output_of(command: list[str]) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, timeout=120).stdout


found, *counts = output_of([python, "-c", FIND]).rsplit(maxsplit=3)
print(f"  code: {found}; lessons, presets, derivations: {', '.join(counts)}")
assert Path(found).is_relative_to(Path.cwd()) == inside
assert "0" not in counts

pose = json.loads(output_of([*ido, "register", "bunny", "--maps", "bunny-triple-binary", "--epsilon", "0.005"]))
print(f"  registration: {pose['stop']} after {pose['iterations']} iterations")
assert pose["converged"]

options = ["--no-open", "--port", "18080", "--lesson", "histogram", "--data", tempfile.mkdtemp()]
with subprocess.Popen([*ido_viz, *options], stdout=subprocess.PIPE, text=True) as explorer:
    try:
        assert explorer.stdout
        said = explorer.stdout.readline()
        url = next(word for word in said.split() if word.startswith("http"))
        with urllib.request.urlopen(url, timeout=30) as answer:
            status, page = answer.status, answer.read().decode()
        explorer.send_signal(signal.SIGINT)
        code = explorer.wait(timeout=30)
    finally:
        explorer.kill()
print(f"  page: status {status}, {len(page):,} characters; exit code after Ctrl-C: {code}")
assert status == 200 and "<title>Viser</title>" in page and code == 0
