"""Make results.npz of what `ido experiment run` wrote: `python assets/scripts/make_results.py ido-results.sqlite`."""

import sys
from pathlib import Path

from ido.experiments.store import Store

with Store.view(Path(sys.argv[1])) as store:
    store.results().save(Path(__file__).parents[1] / "results.npz")
