"""Make results.npz of what `ido experiment run` wrote: `python assets/scripts/make_results.py ido-results.sqlite ...`.

Files are those of runs, or results.npz itself to keep what is there; of a registration that several have, the first
counts.
"""

import sys
from pathlib import Path

from ido.experiments.store import Store
from ido.results import Results


def read(path: Path) -> Results:
    if path.suffix == ".npz":
        return Results.load(path)
    with Store.view(path) as store:
        return store.results()


Results.merged([read(Path(name)) for name in sys.argv[1:]]).save(Path(__file__).parents[1] / "results.npz")
