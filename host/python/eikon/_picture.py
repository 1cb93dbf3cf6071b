# SPDX-License-Identifier: Apache-2.0
"""Pictures: the layers of an OpenEXR file as arrays."""
from __future__ import annotations

import math
import os
import shutil
import tempfile
import weakref
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Optional, Sequence, Union

from . import _eikon

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float32]

PathLike = Union[str, bytes, "os.PathLike[str]"]
CHANNELS = ("R", "G", "B")  # that are shown
LETTERS = "RGBAXYZUV"  # of channels, in the order in which they stand in arrays


@dataclass(frozen=True)
class PredictedError:
    """The relMSE of a picture: the mean of (x - truth)^2 / (truth^2 + 0.01) over its pixels and R, G, B, as predicted from
    the spread of independent parts of its samples, and the 95 % confidence interval of that."""

    relmse: float
    low: float
    high: float  #: infinity where no upper end can be stated

    def __str__(self) -> str:
        return f"relMSE {self.relmse:.3e} (95 %: {self.low:.3e} to {self.high:.3e})"


@dataclass(frozen=True)
class Comparison:
    """How far the test's R, G, B (x) are from the reference's (r), in means over pixels and channels."""

    mse: float  #: of (x - r)^2
    relmse: float  #: of (x - r)^2 / (r^2 + 0.01)
    mape: float  #: of |x - r| / (|r| + 0.01)
    ratio_of_means: float  #: mean(x) / mean(r)
    nonfinite: int  #: values left out


def encoded(text: PathLike) -> bytes:
    """A word or a name of a file as the system has it: names may hold bytes that are no text. raises UsageError"""
    try:
        data = os.fsencode(text)
    except UnicodeEncodeError:
        data = b"\0"
    if b"\0" in data:
        raise _eikon.UsageError(f"{ascii(os.fspath(text))}: no name of a file has such characters")
    return data


def shown(path: PathLike) -> str:
    """A name of a file in a message, where bytes that are no text are escaped."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def layers_of(planes: Dict[str, Array]) -> Dict[str, Array]:
    """Stacks the channels of each layer: R, G, B are `rgb`, A is `alpha`, and albedo.R, .G, .B are `albedo`."""
    import numpy as np

    names: Dict[str, List[str]] = {}
    for channel in planes:
        layer, _, letter = channel.rpartition(".")
        if not layer:
            layer = "rgb" if letter in ("R", "G", "B") else "alpha" if letter == "A" else letter
        names.setdefault(layer, []).append(channel)

    def place(channel: str) -> int:
        return LETTERS.find(channel.rpartition(".")[2])

    return {layer: planes[channels[0]] if len(channels) == 1 else np.stack([planes[c] for c in sorted(channels, key=place)], -1)
            for layer, channels in names.items()}


class Picture:
    """The picture and all layers of an OpenEXR file.

    ``rgb`` is linear radiance, W/(sr m^2), as float32 of shape (height, width, 3), with rows from the top. ``layers`` has it
    and every other layer by name, of shape (height, width) where a layer has one channel, and (height, width, channels) else.
    ``picture["depth"]`` is short for ``picture.layers["depth"]``.
    """

    def __init__(self, path: PathLike, folder: Optional[TemporaryFolder] = None):
        file = _eikon.read_exr(encoded(path))
        self.path = Path(os.fsdecode(path))
        self._folder = folder  # which holds the file, if it is not the user's
        self.metadata: Dict[str, str] = file["metadata"]
        self._planes: Dict[str, Array] = file["planes"]
        self._layers: Optional[Dict[str, Array]] = None

    @property
    def layers(self) -> Dict[str, Array]:
        if self._layers is None:
            self._layers = layers_of(self._planes)
        return self._layers

    @property
    def rgb(self) -> Array:
        """raises UsageError for a picture without R, G and B"""
        self._require(CHANNELS)
        return self.layers["rgb"]

    def __getitem__(self, layer: str) -> Array:
        return self.layers[layer]

    def __iter__(self) -> Iterator[str]:
        return iter(self.layers)

    @property
    def width(self) -> int:
        return int(self._a_plane().shape[1])

    @property
    def height(self) -> int:
        return int(self._a_plane().shape[0])

    @property
    def error(self) -> Optional[PredictedError]:
        """The predicted error; None of a picture of one sample per pixel, or of another program."""
        if "relmsePredicted" not in self.metadata:
            return None
        return PredictedError(float(self.metadata["relmsePredicted"]), float(self.metadata["relmsePredictedLow"]),
                              float(self.metadata.get("relmsePredictedHigh", math.inf)))

    def save(self, path: PathLike, *, exposure: float = 0, ev100: Optional[float] = None, tonemap: str = "none") -> None:
        """Writes the picture: all of it as a file .exr, or an 8-bit sRGB picture .png.

        exposure  of the PNG, in stops; ev100 instead: as a camera set to it
        tonemap   its curve: none, reinhard, aces, agx or pbr-neutral
        raises    UsageError for another ending, for a PNG of a picture without R, G and B, and for an exposure beyond -64 to 64
                  or an ev100 beyond -32 to 32; InputError when the file cannot be written
        """
        if ev100 is not None and exposure != 0:
            raise _eikon.UsageError("save: exposure and ev100 exclude each other")
        path = Path(os.fsdecode(path))
        ending = path.suffix.lower()
        if ending == ".png":
            _eikon.write_png(encoded(path), self._shown(), exposure, ev100, tonemap)
        elif ending == ".exr":
            copy_whole(self.path, path)
        else:
            raise _eikon.UsageError(f"save: cannot tell the format of '{shown(path)}'; end it in .exr or .png")

    def _shown(self) -> Dict[str, Array]:
        """The channels of a PNG: the denoised picture if there is one."""
        prefix = "denoised." if "denoised.R" in self._planes else ""
        self._require([prefix + c for c in CHANNELS])
        shown = {c: self._planes[prefix + c] for c in CHANNELS}
        if "A" in self._planes:
            shown["A"] = self._planes["A"]
        return shown

    def _a_plane(self) -> Array:
        return next(iter(self._planes.values()))

    def _require(self, channels: Sequence[str]) -> None:
        """raises UsageError unless the picture has these channels"""
        missing = [channel for channel in channels if channel not in self._planes]
        if missing:
            raise _eikon.UsageError(f"\"{shown(self.path)}\": has no channel {missing[0]}, so it has no colour to show; its layers are "
                                    f"{', '.join(self.layers)}: take one of these as an array, by picture[\"{next(iter(self))}\"]")

    def _repr_png_(self) -> Optional[bytes]:
        """The picture in a notebook, which shows the text of one that has no colour."""
        if any(channel not in self._planes for channel in CHANNELS):
            return None
        with tempfile.TemporaryDirectory(prefix="eikon.") as folder:
            self.save(Path(folder) / "picture.png")
            return (Path(folder) / "picture.png").read_bytes()

    def __repr__(self) -> str:
        return f"<eikon.{type(self).__name__} {self.width} x {self.height}, {', '.join(self.layers)}; {self.error or 'error unknown'}>"


class TemporaryFolder:
    """A folder that is removed when nobody holds this any more."""

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="eikon."))
        self.remove = weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)


def write_whole(target: Path, write: Callable[[Path], Any]) -> None:
    """Lets `write` write a file, which appears complete or not at all. raises InputError"""
    temporary = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        try:
            write(temporary)
            os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise _eikon.InputError(f"cannot write \"{shown(target)}\": {error.strerror}") from None


def copy_whole(source: Path, target: Path) -> None:
    """Copies a file by write_whole. raises InputError"""
    write_whole(target, lambda temporary: shutil.copyfile(source, temporary))


def read(path: PathLike) -> Picture:
    """Reads an OpenEXR file. raises InputError"""
    return Picture(path)


def planes_of(picture: Any) -> Dict[str, Array]:
    """R, G, B of a picture, of a file, or of an array of shape (height, width, 3)."""
    import numpy as np

    if isinstance(picture, (str, bytes, os.PathLike)):
        picture = read(picture)
    if isinstance(picture, Picture):
        return {c: picture._planes[c] for c in "RGB" if c in picture._planes}
    array = np.asarray(picture, np.float32)
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        raise _eikon.UsageError(f"a picture is an array of shape (height, width, 3), with pixels, not {array.shape}")
    return {c: np.ascontiguousarray(array[:, :, i]) for i, c in enumerate("RGB")}


def compare(test: Union[Picture, PathLike, Array], reference: Union[Picture, PathLike, Array]) -> Comparison:
    """Measures how far a picture is from a reference of the same size. raises UsageError, InputError"""
    return Comparison(**_eikon.compare(planes_of(test), planes_of(reference)))
