"""The explorer with a feature and a method of one's own: `python assets/examples/06_own_feature_in_the_page.py`.

From the command line the same is

    ido-viz --method assets/examples/04_own_method.py:PointToPlane \
            --histogram assets/examples/05_own_feature.py:InsideOutsideAsked

and in a notebook `ido_viz.show(methods={...})` as a cell's last line shows the page in the cell.
"""

from pathlib import Path

import ido_viz
from ido.extensions import find_class

HERE = Path(__file__).parent

page = ido_viz.show(
    methods={
        "Inside / outside": find_class(f"{HERE / '05_own_feature.py'}:InsideOutsideAsked"),  # trained when it is shown
        "Point to plane": find_class(f"{HERE / '04_own_method.py'}:PointToPlane"),
    },
    right="Point to plane",
    rotation=30,
)
print(f"open {page.url}; the page trains the feature first, half a minute")
input("press Enter to stop ")
page.stop()
