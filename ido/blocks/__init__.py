"""The blocks of a histogram: each a question that every model point asks of every scene point."""

from __future__ import annotations

from ido.blocks.angles import ClockwiseOrAnticlockwise, UpOrDown, azimuth, elevation
from ido.blocks.block import Block, Color, Question, Surface
from ido.blocks.boxes import SIGMA2, SMALLEST_WEIGHT
from ido.blocks.front_back import FrontOrBack

__all__ = [
    "SIGMA2",
    "SMALLEST_WEIGHT",
    "Block",
    "ClockwiseOrAnticlockwise",
    "Color",
    "FrontOrBack",
    "Question",
    "Surface",
    "UpOrDown",
    "azimuth",
    "elevation",
]
