"""A cloud with the maps trained on it, as one file: a maps file that `ido register` reads, too, with more in it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ido import Cloud, FrontBack, Histogram, Maps, MapsError, TripleBinary
from ido.disk import write_whole
from ido.methods import LEARNED
from ido.npz import packed, promises, read_arrays
from ido_viz.core.library import Subject
from ido_viz.own.draft import MOST_POINTS, UNITS, UPS, shown_name

TRAINED: dict[str, type[Histogram]] = {"DO": FrontBack, "Improved DO": TripleBinary}
"""The methods that are trained on a cloud; the last one's maps are those that the file is for other programs."""

MOST_UNPACKED = 200 << 20
"""Bytes of all arrays of a file."""

_METHOD_OF = {histogram: method for method, histogram in LEARNED.items()}
_REMEDY = "upload what was downloaded here, or a file of `ido train`"


@dataclass(frozen=True, slots=True, eq=False)
class KeptCloud:
    """A cloud and what was learned on it.

    Args:
        name: as it is listed.
        unit: that the cloud's frame is in.
        up: name of the direction that is up, in `UPS`.
        cloud: normalised.
        maps: by the method's name, at least one; all of the cloud's frame.
    """

    name: str
    unit: str
    up: str
    cloud: Cloud
    maps: Mapping[str, Maps]

    @property
    def best(self) -> Maps:
        """The last of its maps, by which scans are registered."""
        return list(self.maps.values())[-1]

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all."""
        *others, last = self.maps.values()
        arrays = last.arrays()
        for maps in others:
            arrays |= {f"{maps.histogram.name}/{name}": values for name, values in maps.arrays().items()}
        head = Head(self.name, self.unit, self.up, tuple(self.maps))
        arrays |= {"kept": np.array(head.text()), "kept_cloud": self.cloud.points}
        write_whole(path, packed(arrays))

    @classmethod
    def load(cls, path: Path, otherwise: str = "cloud") -> KeptCloud:
        """Read a file that `save` or `ido train` wrote; of the latter, the model stands for the cloud.

        Args:
            path: the file.
            otherwise: what the cloud is called if the file does not say.

        Raises:
            MapsError: it cannot be used.
        """
        try:
            size = sum(promise.size for promise in promises(path).values())
        except Exception:  # read_arrays says what is wrong with it
            size = 0
        if size > MOST_UNPACKED:
            raise MapsError(f"{path.name}: unpacks to {size >> 20} MB; at most {MOST_UNPACKED >> 20} MB are read")
        arrays = read_arrays(path, MapsError, "a maps file", _REMEDY)
        last = Maps.of_arrays(arrays)
        head = (
            Head.of(arrays) if "kept" in arrays else Head(otherwise, UNITS[0], "+z", (_METHOD_OF[last.histogram.name],))
        )
        maps = {}
        for method in head.methods:
            prefix = f"{LEARNED[method]}/"
            its = {key.removeprefix(prefix): values for key, values in arrays.items() if key.startswith(prefix)}
            maps[method] = Maps.of_arrays(its) if its else last
            if maps[method].histogram.name != LEARNED[method]:
                raise MapsError(f"{path.name}: its maps are not those of {method}")
            if not np.array_equal(maps[method].histogram.model.points, last.histogram.model.points):
                raise MapsError(f"{path.name}: its methods were not trained on one cloud")
        points = np.asarray(arrays.get("kept_cloud", last.histogram.model.points))
        usable = points.ndim == 2 and points.shape[1] == 3 and 10 <= len(points) <= MOST_POINTS
        if not (usable and points.dtype == np.float32 and (np.abs(points) <= 2).all()):  # also false for NaN
            raise MapsError(f"{path.name}: the cloud in it cannot be used")
        return cls(shown_name(head.name), head.unit, head.up, Cloud(points, last.frame), maps)

    def subject(self) -> Subject:
        """It as a shape of the page."""
        return Subject(
            title_of(self.unit, self.best.complete),
            cloud=lambda: self.cloud,
            maps={method: lambda maps=maps: maps for method, maps in self.maps.items()},
            up=UPS[self.up],
        )


@dataclass(frozen=True, slots=True)
class Head:
    """What is known of a file without reading all of it; see `KeptCloud`."""

    name: str
    unit: str
    up: str
    methods: tuple[str, ...]

    def text(self) -> str:
        return json.dumps({"name": self.name, "unit": self.unit, "up": self.up, "methods": self.methods})

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Head:
        """The head among a file's arrays.

        Raises:
            MapsError: it is none of ours.
        """
        try:
            values = json.loads(str(arrays["kept"]))
            head = cls(str(values["name"]), values["unit"], values["up"], tuple(values["methods"]))
            known = head.unit in UNITS and head.up in UPS and all(method in LEARNED for method in head.methods)
            if not (known and head.methods):
                raise ValueError("its head names what is not known here")
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise MapsError(f"it is damaged ({error}); {_REMEDY}") from error
        return head


def title_of(unit: str, complete: bool) -> str:
    """What is said of a kept cloud in the menu of shapes."""
    return f"your own cloud, in {unit}" + ("" if complete else ", still learning")
