"""Make results.npz of what `ido experiment run paper` wrote: `python assets/make_results.py ido-results.sqlite`."""

import sys
from pathlib import Path

from ido.experiments.store import Store

with Store.view(Path(sys.argv[1])) as store:
    store.results().save(Path(__file__).with_name("results.npz"))
