"""A run as a moving picture for slides, .gif: both panes side by side, drawn here in a few fixed colours."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ido import poses
from ido.types import FloatArray
from ido_viz.core import palette
from ido_viz.core.background import Report
from ido_viz.core.frame import Frame, SideFrame, frame_at
from ido_viz.core.geometry import error_vectors, track_of
from ido_viz.core.pacing import Pacing
from ido_viz.core.palette import Color
from ido_viz.core.run import Run
from ido_viz.core.state import State
from ido_viz.core.wording import scene_line
from ido_viz.files.projection import Dots, View

SIZE = (1280, 720)
"""Width and height of the animation, pixels: the shape of a slide."""

MOST_FRAMES = 80
"""A longer animation has this many frames, further apart."""

HOLD = 1000
"""Milliseconds that the start and the end are shown."""

_APART = 0.1  # seconds between two frames
_TOP, _BOTTOM = 118, 82  # pixels above and below the panes
_WIDTH, _HEIGHT = SIZE[0] // 2, SIZE[1] - _TOP - _BOTTOM
_FINER = 2  # a pixel is averaged from so many squared
_SMALLEST = 14  # pixels of type, below which a line is cut
_GREYS = 5  # of the model, by height
_STEPS = 4  # in which a colour fades into the page's: as many as averaging makes


def animation_gif(frame: Frame, report: Report = lambda _: None) -> bytes:
    """Both registrations of a page from the start to the end, in a loop, at the pace of the page (see `pacing`).

    It shows what the canvas shows while playing: titles with iterations and scores, the model, the scene with its
    outliers and, as far as the state asks for them, where it belongs, error vectors and overlays; light or dark. The
    report is told of each picture; what it raises ends the work.
    """
    run, state = frame.run, frame.state
    positions, apart = Pacing(run).moments(state.speed, _APART, MOST_FRAMES)
    each = 10 * round(100 * apart)
    slide = _Slide(run, state, sorted({int(position) for position in positions}))

    def drawn() -> Iterator[Image.Image]:
        for number, position in enumerate(positions, 1):
            report(f"drawn, picture {number} of {len(positions)}")
            yield slide.frame(position)

    frames = drawn()
    content = io.BytesIO()
    next(frames).save(
        content,
        format="GIF",
        save_all=True,
        append_images=frames,
        duration=[HOLD, *[each] * (len(positions) - 2), HOLD],
        loop=0,
        disposal=1,  # each frame is drawn over the last
        comment=f"{' and '.join(side.method for side in run.sides)} on {scene_line(state)}".encode(),
    )
    return content.getvalue()


class _Slide:
    """Draws the frames of a run, all in the same colours and from the same place."""

    def __init__(self, run: Run, state: State, iterations: Sequence[int]) -> None:
        self._run, self._state = run, state
        self._colors = _Colors(state.dark, [palette.method_color(side.method, state.dark) for side in run.sides])
        self._larger = 1.25 if state.large_text else 1.0
        scene = run.scene
        self._true_points, self._outliers = scene.points[~scene.is_outlier], scene.points[scene.is_outlier]
        self._belongs = poses.transform(scene.T_model_scene, self._true_points)
        self._view = View.over(self._in_sight(iterations), run.subject.up, (_WIDTH * _FINER, _HEIGHT * _FINER))
        self._page = self._empty_page()

    def _in_sight(self, iterations: Sequence[int]) -> FloatArray:
        """Model points and scene points wherever they are, shape (n, 3); outliers only if they form something."""
        run = self._run
        points = run.scene.points if self._state.perturbation.outlier_kind == "structured" else self._true_points
        places = [self._belongs]
        for side in run.sides:
            places.append(side.histogram.model.points)
            shown = sorted({side.clipped(k) for k in iterations})
            places += [poses.transform(side.T_model_scene[k], points) for k in shown]
        return np.concatenate(places)

    def frame(self, position: float) -> Image.Image:
        """Both panes after so many iterations and a fraction of the next."""
        page = self._page.copy()
        for side in frame_at(self._run, self._state, position).sides:
            page.paste(self._pane(side), (side.pane * _WIDTH, _TOP))
            self._title(ImageDraw.Draw(page), side)
        ImageDraw.Draw(page).line((_WIDTH, 24, _WIDTH, SIZE[1] - _BOTTOM), fill=self._colors.rgb("line"), width=1)
        return self._colors.reduced(page)

    def _pane(self, side: SideFrame) -> Image.Image:
        run, state, number = self._run, self._state, self._colors.number
        pane, T = side.pane, side.T_model_scene
        model = side.run.histogram.model.points
        greys = number("model 0") + _levels(model @ np.array(run.subject.up), _GREYS)
        layers = [Dots(model, greys, 0.012), self._dots(poses.transform(T, self._outliers), "outlier", 0.009)]
        if state.ghost:
            layers.append(self._dots(self._belongs, "ghost", 0.011))
        if side.overlay is not None:
            color = f"method {1 - pane}" if state.overlay == "other method" else f"pale {pane}"
            layers.append(self._dots(poses.transform(side.overlay.T_model_scene, self._true_points), color, 0.012))
        moved = poses.transform(T, self._true_points)
        layers.append(self._dots(moved, f"method {pane}", 0.017, rim=1.5, ahead=0.1))  # covers where it belongs

        fine = Image.new("L", self._view.size, 0)
        lines = ImageDraw.Draw(fine)
        if state.error_vectors:
            self._view.draw_lines(lines, error_vectors(run.scene, T), number("ghost"), 2)
        self._view.draw_lines(lines, track_of(run.scene, side.run.T_model_scene), number(f"method {pane}"), 3)
        return self._colors.picture(self._view.stamp(np.asarray(fine), layers)).reduce(_FINER)

    def _dots(self, points: FloatArray, color: str, radius: float, **options: float) -> Dots:
        return Dots(points, np.full(len(points), self._colors.number(color)), radius, **options)

    def _title(self, page: ImageDraw.ImageDraw, side: SideFrame) -> None:
        middle, room = (side.pane + 0.5) * _WIDTH, _WIDTH - 40
        caption = side.caption
        shown = ", ".join(filter(None, (caption.progress, caption.overlay)))
        self._text(page, (middle, 34), caption.method, 34 * self._larger, f"method {side.pane}", room, bold=True)
        self._text(page, (middle, 73), shown, 21 * self._larger, "ink", room)
        if caption.scores:
            self._text(page, (middle, 102), "  ·  ".join(caption.scores), 21 * self._larger, "ink", room)

    def _text(
        self,
        page: ImageDraw.ImageDraw,
        place: tuple[float, float],
        text: str,
        size: float,
        color: str,
        room: float,
        *,
        bold: bool = False,
    ) -> None:
        """Write a line around a place, smaller or cut where it would be wider than its room."""
        text = " ".join(text.split())
        font = _font(round(size), bold)
        while font.getlength(text) > room and font.size > _SMALLEST:
            font = _font(round(font.size) - 1, bold)
        while font.getlength(text) > room:
            text = text[:-2] + "…"
        page.text(place, text, font=font, fill=self._colors.rgb(color), anchor="mm")

    def _empty_page(self) -> Image.Image:
        """What all frames share: what the colours mean, and what scene it is."""
        page = Image.new("RGB", SIZE, self._colors.rgb("page"))
        draw = ImageDraw.Draw(page)
        legend = {"model": ["model 2"], "scene": ["method 0", "method 1"], "outliers": ["outlier"]}
        if self._state.ghost:
            legend["where it belongs"] = ["ghost"]
        font, dot, gap = _font(round(18 * self._larger), False), 20, 34
        wide = sum(dot * len(colors) + font.getlength(name) + gap for name, colors in legend.items()) - gap
        x, y = (SIZE[0] - wide) / 2, SIZE[1] - 54
        for name, colors in legend.items():
            for color in colors:
                draw.ellipse((x, y - 6, x + 12, y + 6), fill=self._colors.rgb(color))
                x += dot
            draw.text((x, y), name, font=font, fill=self._colors.rgb("ink"), anchor="lm")
            x += font.getlength(name) + gap
        place = (SIZE[0] / 2, SIZE[1] - 22)
        self._text(draw, place, scene_line(self._state), 16 * self._larger, "faint", SIZE[0] - 40)
        return page


class _Colors:
    """The fixed colours of an animation: the page's, the names', and each name's on its way to the page's."""

    def __init__(self, dark: bool, methods: list[Color]) -> None:
        page = (30, 30, 30) if dark else (255, 255, 255)
        low, high = palette.model_greys(dark)
        greys = np.linspace(low, high, _GREYS).astype(int).tolist()
        named: dict[str, Color] = {
            "page": page,
            "ink": palette.ink(dark),
            "faint": palette.lighter(palette.ink(dark), dark, 0.35),
            "line": palette.lighter(palette.ink(dark), dark, 0.8),
            "outlier": palette.OUTLIER,
            "ghost": palette.GHOST,
            **{f"method {i}": color for i, color in enumerate(methods)},
            **{f"pale {i}": palette.lighter(color, dark) for i, color in enumerate(methods)},
            **{f"model {i}": (grey, grey, grey) for i, grey in enumerate(greys)},
        }
        self._numbers = {name: number for number, name in enumerate(named)}
        self._full = np.array(list(named.values()), dtype=np.uint8)
        shares = np.arange(1, _STEPS + 1)[:, None, None] / _STEPS
        faded = np.array(page) + shares * (self._full[1:].astype(float) - np.array(page))
        self._all = np.concatenate([[page], np.rint(faded).reshape(-1, 3)]).astype(np.uint8)
        fives = np.stack(np.meshgrid(*[np.arange(32)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3) * (255 / 31)
        self._nearest = ((fives - self._all.astype(float)) ** 2).sum(axis=-1).argmin(axis=1).astype(np.uint8)

    def number(self, name: str) -> int:
        """Of a colour in an array of pixels."""
        return self._numbers[name]

    def rgb(self, name: str) -> Color:
        r, g, b = self._full[self._numbers[name]].tolist()
        return r, g, b

    def picture(self, pixels: np.ndarray) -> Image.Image:
        """An array of colours' numbers, shape (height, width), as a picture."""
        picture = Image.fromarray(np.ascontiguousarray(pixels))
        picture.putpalette(self._full.tobytes())
        return picture.convert("RGB")

    def reduced(self, picture: Image.Image) -> Image.Image:
        """A picture in the fixed colours, each pixel in the nearest one."""
        r, g, b = np.moveaxis(np.asarray(picture).astype(np.uint16) >> 3, -1, 0)
        fixed = Image.fromarray(self._nearest[(r << 10) | (g << 5) | b])
        fixed.putpalette(self._all.tobytes())
        return fixed


def _levels(values: FloatArray, count: int) -> np.ndarray:
    """In which of so many equal steps between the smallest and the largest each value lies, from 0."""
    share = (values - values.min()) / max(float(np.ptp(values)), 1e-9)
    return np.minimum((share * count).astype(np.int64), count - 1)


@cache
def _font(size: int, bold: bool) -> ImageFont.FreeTypeFont:
    """DejaVu Sans, which Matplotlib brings along."""
    import matplotlib  # takes a while to import

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)
