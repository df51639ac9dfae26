"""The tab Help: what the page is about, in plain words."""

from __future__ import annotations

import viser

_HELP = """
**Two methods register the same scene**, side by side. The scene is a copy of the grey *model* that was turned, moved,
made noisy, cut off and mixed with outliers. Each method has to find the way back, step by step, to where the green
markers are. Press **Play**, then drag a slider on the left, or the cloud itself by its rings and arrows.

**How they move.** At every iteration a method looks at the scene through a *histogram*, and a learned *map* turns what
it sees into the next update of the pose: `x ← x - D · h(x)`. There are 30 maps; the last one is repeated until the
updates are smaller than ε.

**What they see.** Each model point asks of the scene points near it: in front of me, or behind me? That is DO, and
gives two bins for each model point. Improved DO also asks of all scene points: above me or below me, clockwise or
anticlockwise of me?

**The histograms** show every bin as a dot. The line is the *reference*: what the model sees of itself. When the scene
is in its place, the dots gather along it.

**The maps** show, for each bin, how it pushes the six numbers of the pose: translation ρ and rotation φ, one way in
blue and the other in red.

**From any start.** *Global* tries many poses and climbs from the best of them. Each small dart is one of them: it flies
over the top of the model as that pose would have it, so darts that agree are in one place. Those given up fade. At the
end it says how sure it is, without knowing the truth, and faint points show what else the pose may be. **Basin** maps
from which turns each method comes back.
"""


class HelpTab:
    """The text."""

    def __init__(self, gui: viser.GuiApi) -> None:
        gui.add_markdown(_HELP)
