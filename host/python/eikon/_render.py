# SPDX-License-Identifier: Apache-2.0
"""Renders, meters and merges: each is the command of that name, whose flags are keywords here."""
from __future__ import annotations

import functools
import json
import operator
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, FrozenSet, List, Optional, Sequence, Tuple, Union

from . import _eikon
from ._picture import PathLike, Picture, TemporaryFolder, copy_whole, encoded
from ._scene import Scene, plain

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    SceneLike = Union[str, "os.PathLike[str]", bytes, Scene]
    Vector = Tuple[float, float, float]

LISTS = (list, tuple, range, set, frozenset)  # that a value may be
ON_OR_OFF = {"energy_compensation"}  # flags that take on or off
SEPARATORS = {"size": "x", "samples": ":", "frames": ":", "look_at": ":"}  # of the parts of a value; others have commas
REPEATED = {"add"}  # flags that take one value each time that they are given
NOT_HERE = {"pixel", "sample", "frames", "progress"}


@dataclass(frozen=True)
class Progress:
    share: float  #: of the work that is done, 0 to 1
    samples: int
    samples_per_second: float
    seconds: float  #: of rendering so far
    seconds_left: float


@dataclass(frozen=True)
class Device:
    """An OpenCL device; `index` and `name` are what the keyword `devices` of render() takes."""

    index: int
    name: str
    vendor: str
    platform: str
    driver: str
    kind: str  #: cpu, gpu or accelerator
    compute_units: int
    memory_bytes: int
    unusable: str  #: why it cannot be used; empty: it can


@dataclass(frozen=True)
class Reading:
    """A measurement of a light meter, and its standard error, both R, G, B."""

    quantity: str  #: irradiance or radiance
    unit: str
    value: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    side: float  #: of the square over which it is a mean, metres
    paths: int  #: that it is a mean of
    rejected: int  #: paths that were left out, because they were not finite or beyond the film's range
    notes: List[str]  #: what the program would have said


class Render(Picture):
    """A picture that render() made."""

    def __init__(self, path: Path, folder: TemporaryFolder, stats: Dict[str, Any], notes: List[str], code: int):
        super().__init__(path, folder)
        self.as_asked = code == 0  #: False where the program exits with another code: notes say why
        self.stats = stats  #: counts and times, as `eikon render --stats` writes them
        self.notes = notes  #: what the program would have said: defaults that were chosen, faults of the scene

    @property
    def interrupted(self) -> bool:
        """True if progress ended it before its time."""
        return bool(self.stats["interrupted"])


def text_of(flag: str, value: Any) -> str:
    """A value as the command line has it: numbers so that they read back to the bit, tuples with separators."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, (str, bytes, os.PathLike)):
        return os.fsdecode(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, LISTS):
        inner = "look_at element" if flag == "look_at" else flag
        return SEPARATORS.get(flag, ",").join(text_of(inner, part) for part in value)
    return repr(value)


def named(key: str, text: str) -> str:
    """The text of a value, which names no standard output: the program keeps that for a file, and Python would lose it.
    raises UsageError"""
    if text == "":
        raise _eikon.UsageError(f"{key}: the text is empty; give a value, or leave {key} out")
    if text == "-":
        raise _eikon.UsageError(f"{key}: standard output belongs to Python; name a file")
    return text


def file_of(key: str, value: Any) -> str:
    """The name of a file that a keyword gives. raises UsageError"""
    if not isinstance(value, (str, bytes, os.PathLike)):
        raise _eikon.UsageError(f"{key}: takes the name of a file, not {type(value).__name__}")
    return named(key, os.fsdecode(value))


@functools.lru_cache(maxsize=None)
def valued_keywords(command: str) -> FrozenSet[str]:
    """The keywords of a command whose flags take a value."""
    return frozenset(_eikon.valued_keywords(command))


def words_of(command: str, flags: Dict[str, Any]) -> List[str]:
    """The flags of a command that keywords stand for; those that are None, False or empty lists are left out. raises
    UsageError"""
    words: List[str] = []
    for key, value in flags.items():
        flag = "--" + key.rstrip("_").replace("_", "-")
        value = value.tolist() if hasattr(value, "tolist") else value
        is_list = isinstance(value, LISTS)
        if value is None or (value is False and key not in ON_OR_OFF) or (is_list and len(value) == 0):
            continue
        if value is True and key not in ON_OR_OFF:
            if key.rstrip("_") in valued_keywords(command):
                raise _eikon.UsageError(f"{key}: takes a value, and True is none; give one, or leave {key} out")
            words.append(flag)
        else:
            values = value if is_list and key in REPEATED else [value]
            words += [f"{flag}={named(key, text_of(key, each))}" for each in values]
    return words


def camera_words(camera: Any) -> List[str]:
    """A camera by name, by index, or by the matrix that takes its space, where it looks along -Z, to the world."""
    if camera is None:
        return []
    if isinstance(camera, str):
        return [f"--camera={camera}"]
    try:
        return [f"--camera={operator.index(camera)}"]
    except TypeError:
        pass  # it is no index, of Python or of numpy
    import numpy as np

    matrix = np.asarray(camera, np.float64)
    if matrix.shape != (4, 4):
        raise _eikon.UsageError(f"camera: takes a name, an index, or a matrix of shape (4, 4), not {matrix.shape}")
    axes = matrix[:3, :3]
    if not np.allclose(axes.T @ axes, np.eye(3), atol=1e-5) or np.linalg.det(axes) < 0:
        raise _eikon.UsageError("camera: the matrix of a camera is a rotation and a translation, without a scale")
    eye = matrix[:3, 3]
    return words_of("render", {"look_at": (eye, eye - axes[:, 2], axes[:, 1])})


class SceneFile:
    """A scene as a file, for as long as a `with` block lasts."""

    def __init__(self, scene: SceneLike):
        self._folder: Optional[TemporaryFolder] = None
        if isinstance(scene, (str, os.PathLike)):
            self.path = os.fsdecode(scene)
            return
        data = scene.to_glb() if isinstance(scene, Scene) else scene
        if not isinstance(data, (bytes, bytearray, memoryview)):
            raise _eikon.UsageError(f"a scene is a path, the bytes of a .glb or .gltf file, or an eikon.Scene, not {type(scene)}")
        self._folder = TemporaryFolder()
        name = "scene.glb" if bytes(data[:4]) == b"glTF" else "scene.gltf"
        self.path = os.fspath(self._folder.path / name)
        Path(self.path).write_bytes(data)

    def __enter__(self) -> str:
        return self.path

    def __exit__(self, *_: object) -> None:
        if self._folder is not None:
            self._folder.remove()


def render(scene: SceneLike, *, spp: Optional[int] = None, size: Optional[Tuple[int, int]] = None,
           camera: Union[str, int, ArrayLike, None] = None, fov: Optional[float] = None,
           look_at: Optional[Sequence[Vector]] = None, env: Union[str, Vector, None] = None,
           aov: Union[str, Sequence[str], None] = None, samples: Optional[Tuple[int, int]] = None,
           crop: Optional[Tuple[int, int, int, int]] = None, seed: Optional[int] = None,
           target_error: Union[float, str, None] = None, time: Optional[float] = None, devices: Optional[str] = None,
           progress: Optional[Callable[[Progress], Any]] = None, **flags: Any) -> Render:
    """Renders a scene, with the bits of `eikon render` with the same flags.

    scene     a path, the bytes of a .glb or .gltf file, or an eikon.Scene
    spp       samples per pixel [64]
    size      (width, height) in pixels [720 rows at the camera's aspect]
    camera    name or index of a camera of the scene [the first]; or the matrix of shape (4, 4), world from camera, of a camera
              that looks along its -Z with +Y up; fov is its vertical field of view in degrees
    look_at   (eye, target) or (eye, target, up), in metres
    env       "none", "neutral", the file of a map, or a constant radiance (R, G, B)
    aov       names of layers: albedo, normal, depth, ...
    samples   (begin, end): these samples alone, for merge()
    crop      (x0, y0, x1, y1): this window alone
    target_error, time   end when the relMSE is below, or after so many seconds
    progress  called some four times a second with a Progress; the render ends with what is done when it returns False
    flags     every other flag of `eikon render --help`, with _ for -: denoise=True, filter="gaussian", light_paths="off"

    Returns the picture with all its layers. Other threads of Python run meanwhile. Ctrl-C ends it with KeyboardInterrupt; use
    `checkpoint` and `resume` to keep what is done.
    raises UsageError, InputError, DeviceError
    """
    wrong = NOT_HERE.intersection(flags)
    if wrong:
        raise _eikon.UsageError(f"render: takes no '{min(wrong)}' in Python; `eikon render` does")
    if not (progress is None or callable(progress)):
        raise _eikon.UsageError(f"progress: takes a function, not {type(progress).__name__}")
    folder = TemporaryFolder()
    file = folder.path / "render.exr"
    # The program gets the names that the user gives, so that its checks before the render hold for
    # them.
    output, stats = (default if flags.get(key) is None else file_of(key, flags[key])
                     for key, default in (("output", file), ("stats", folder.path / "stats.json")))
    flags.update(output=output, stats=stats, spp=spp, size=size, fov=fov, look_at=look_at, env=env, aov=aov, samples=samples,
                 crop=crop, seed=seed, target_error=target_error, time=time, devices=devices)
    with SceneFile(scene) as path:
        words = [path, *camera_words(camera), *words_of("render", flags)]
        code, notes, has_picture = _eikon.render(
            [encoded(word) for word in words],
            None if progress is None else lambda *values: plain(progress(Progress(*values))))  # numpy's False is one of Python's
    if not has_picture:
        raise _eikon.UsageError(notes[-1])  # it ended before its first sample, by progress or time
    if output is not file:
        copy_whole(Path(output), file)  # the picture stays as it is when its user replaces the file
    return Render(file, folder, json.loads(Path(stats).read_text()), notes, code)


def merge(parts: Sequence[Union[Picture, PathLike]], output: Optional[PathLike] = None, **flags: Any) -> Picture:
    """Adds up parts of one image exactly: renders with `samples` or `crop`, and checkpoints. Their order does not matter.

    output  file for the whole; without one it is kept for as long as the Picture is
    warns   when samples between those of the parts are missing
    raises  InputError when the parts are not of one image, or hold a sample twice
    """
    if isinstance(parts, (str, bytes, os.PathLike, Picture)):
        raise _eikon.UsageError("merge: takes a list of parts; put a single one in brackets")
    folder = TemporaryFolder() if output is None else None
    file = folder.path / "merged.exr" if folder else Path(file_of("output", output))
    files = [os.fsdecode(part.path if isinstance(part, Picture) else part) for part in parts]
    words = [*files, f"--output={file}", "--quiet", *words_of("merge", flags)]
    if _eikon.merge([encoded(word) for word in words]) != 0:
        warnings.warn("merge: samples between those of the parts are missing", stacklevel=2)
    return Picture(file, folder)


def meter(scene: SceneLike, at: Vector, *, facing: Optional[Vector] = None, from_: Optional[Vector] = None,
          **flags: Any) -> Reading:
    """Measures light: irradiance at a point on a receiver with the normal `facing`, or the radiance that arrives there `from_` a
    direction. `flags` are those of `eikon meter --help`. raises UsageError, InputError, DeviceError"""
    import numpy as np

    with SceneFile(scene) as path:
        flags.update(at=at, facing=facing, from_=from_)
        text, notes = _eikon.meter([encoded(word) for word in (path, *words_of("meter", flags))])
    found = json.loads(text)
    value, error = np.array(found["value"]), np.array(found["standard_error"])
    return Reading(found["quantity"], found["unit"], value, error, found["side"], found["paths"], found["rejected"], notes)


def devices() -> List[Device]:
    """Every OpenCL device of this machine."""
    return [Device(**device) for device in _eikon.devices()]
