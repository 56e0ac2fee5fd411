"""Contact sheets: many objects in one picture, each numbered, every other one with its joints opened."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..annotate.frames import rotate
from ..arguments import read_whole
from ..errors import UsageError
from ..export.write import ExportError, write_bytes
from ..geometry.resolution import COARSEST, FINEST, STANDARD, Resolution
from ..geometry.sites import object_boxes
from ..records import dataclass
from ..robot.robots import Robots
from .camera import Camera, look_at, place_lights
from .png import png_bytes, srgb, write_number, write_text
from .regions import colours_of, find_regions, words_said
from .scene import COLOURINGS, Scene, hex_colour, make_scene, open_values

if TYPE_CHECKING:
    from ..details.dressing import Dressing
    from ..runtime.batch import Batch

RENDERERS = ("moderngl", "embreex", "numpy")
VIEWS = {  # degrees to the left of the front, and above
    "iso": (33.0, 24.0),
    "front": (0.0, 0.0),
    "back": (180.0, 0.0),
    "left": (90.0, 0.0),
    "right": (-90.0, 0.0),
    "top": (0.0, 90.0),
}
_STATES = ("rest", "open", "alternate")
_TILES = 16, 4096  # pixels: a number below an object has to go into the least
_CORNER = 0.125  # pixels: how far a corner of an outline may lie off the true surface
_DOT = 2  # pixels: of the letters of a legend
BACKDROP = "eaedf1"


def make_renderer(name: str, size: int) -> Any:
    """A renderer by name, or with ``auto`` the first of ``RENDERERS`` that works on this machine."""
    if name != "auto" and name not in RENDERERS:
        raise UsageError(f"unknown renderer {name!r}", f"the renderers are auto, {', '.join(RENDERERS)}")
    reasons = []
    for candidate in RENDERERS if name == "auto" else (name,):
        try:
            return _make(candidate, size)
        except Exception as error:  # a missing library, driver or display, each with its own exception
            reasons.append(f"{candidate}: {error}")
    raise ExportError(f"cannot draw with {'; '.join(reasons)}", "leave the choice of the renderer to the program")


def _make(name: str, size: int) -> Any:
    backdrop = hex_colour(BACKDROP)
    if name == "moderngl":
        from .raster_gl import Renderer as Gl  # extra: render

        return Gl(size, backdrop)
    if name == "embreex":
        from .raster_rays import Renderer as Rays  # extra: rays

        return Rays(size, backdrop)
    from .raster_cpu import Renderer as Plain  # start-up: where neither is there

    return Plain(size, backdrop)


@dataclass(frozen=True, slots=True)
class Shot:
    """What there is to draw, where one looks from, and the height of the ground."""

    scene: Scene
    camera: Camera
    floor: float


class Painter:
    """Draws shots in tiles of some pixels. To another process goes the name of its renderer alone."""

    def __init__(self, which: str, tile: int):
        self.tile, self.renderer = tile, make_renderer(which, tile)

    def __reduce__(self) -> tuple[type[Painter], tuple[str, int]]:
        return Painter, (self.renderer.name, self.tile)

    def paint(self, shot: Shot) -> np.ndarray:
        """The picture (tile, tile, 3) uint8 of a shot."""
        lights = place_lights(shot.camera, *self.renderer.light_counts)
        return srgb(self.renderer.render(shot.scene, shot.camera, lights, shot.floor))


PaintAll = Callable[[Painter, int, Callable[[int], Shot]], Iterable[np.ndarray]]
"""How the pictures of so many shots, each made when it is asked for, come about, in their order."""


def _paint_here(painter: Painter, count: int, shot: Callable[[int], Shot]) -> Iterable[np.ndarray]:
    """One picture after the other, in this process."""
    return (painter.paint(shot(i)) for i in range(count))


def read_tile(tile: Any) -> int:
    """How wide a tile is, in pixels. Raises UsageError."""
    tile = read_whole("tile", tile)
    if not _TILES[0] <= tile <= _TILES[1]:
        raise UsageError(f"a tile is {tile} pixels wide", f"give a number from {_TILES[0]} to {_TILES[1]}")
    return tile


@dataclass(frozen=True, slots=True)
class Sheet:
    """How a contact sheet looks: ``tile`` pixels (16 to 4096) for each object, in so many ``columns``, drawn by the renderer ``which``.

    ``colour``: "part", "material" or "affordance", which has a row below with the words that hold somewhere.
    ``states``: "rest", "open", or "alternate": even tiles at rest, odd ones opened. ``view``: where one looks from, one of
    ``VIEWS`` or (azimuth, elevation) in degrees; None for "iso", from the side on which one sees into what opens.
    ``resolution`` of the meshes, by default as fine as the pixels, but for those of affordances; ``details`` that they wear.
    """

    columns: int | None = None
    tile: int = 256
    colour: str = "part"
    which: str = "auto"
    states: str = "alternate"
    view: str | tuple[float, float] | None = None
    resolution: Resolution | None = None
    details: Dressing | None = None

    @property
    def acting(self) -> bool:
        """Whether it shows where one acts."""
        return self.colour == "affordance"


USUAL = Sheet()


class _Shots:
    """What each tile of a sheet shows."""

    def __init__(self, batch: Batch, sheet: Sheet, columns: int):
        self.batch, self.sheet, self.columns = batch, sheet, columns
        resolution = sheet.resolution or (
            STANDARD if sheet.details is not None else by_pixels(batch, read_tile(sheet.tile))
        )
        self.robots = Robots(batch, resolution=resolution, physics=False, details=sheet.details)
        self.poses = {"rest": batch.pose(), "open": batch.pose(open_values(batch))}
        self.azimuth, self.elevation = read_direction(sheet.view)
        if sheet.view is None:
            self.azimuth *= _side(self.robots, self.poses["open"])
        self.said = set[str]()  # words of labels that hold somewhere, as far as it has been drawn

    def shot(self, i: int) -> Shot:
        """What the tile of object ``i`` shows; on a board of black and white squares, the black ones are opened."""
        opened = (i + i // self.columns * (self.columns % 2 == 0)) % 2
        pose = self.poses[("rest", "open")[opened] if self.sheet.states == "alternate" else self.sheet.states]
        if self.sheet.acting:
            scene, found = find_regions(self.batch, self.robots, i, pose, self.sheet.colour)
            self.said.update(found)
        else:
            scene = make_scene(self.robots, i, pose, self.sheet.colour)
        camera = look_at(scene.vertices, self.azimuth, self.elevation)
        return Shot(scene, camera, float(scene.vertices[:, 2].min()))


def draw_sheet(
    batch: Batch,
    sheet: Sheet = USUAL,
    *,
    paint_all: PaintAll = _paint_here,
    progress: Callable[[int, int], None] | None = None,
) -> np.ndarray:
    """The picture (height, width, 3) uint8 of all objects of a batch. Raises ExportError, UsageError."""
    _require_words(sheet.colour, sheet.states)
    tile, columns = read_tile(sheet.tile), None if sheet.columns is None else read_whole("columns", sheet.columns, 1)
    _require_seen(batch, sheet)
    painter = Painter(sheet.which, tile)
    columns = columns or default_columns(len(batch))
    shots = _Shots(batch, sheet, columns)
    image = np.empty((-(-len(batch) // columns) * tile, columns * tile, 3), dtype=np.uint8)
    image[:] = srgb(hex_colour(BACKDROP))
    pictures = paint_all(painter, len(batch), shots.shot)
    for i, (number, picture) in enumerate(zip(batch.numbers.tolist(), pictures, strict=True)):
        y, x = i // columns * tile, i % columns * tile
        cell = image[y : y + tile, x : x + tile]
        cell[:] = picture
        write_number(cell, number, (120, 126, 134), size=max(1, tile // 160))
        if progress:
            progress(i + 1, len(batch))
    if sheet.acting:
        tints = {word: srgb(tint) for word, tint in colours_of(batch, sheet.colour).items() if word in shots.said}
        image = np.concatenate([image, draw_legend(tints, image.shape[1])])
    return image


def _require_words(colour: str, states: str) -> None:
    """Raise UsageError for a colouring or states that there are not."""
    if not isinstance(colour, str) or colour not in COLOURINGS:
        raise UsageError(f"unknown colouring {colour!r}", f"the colourings are {', '.join(COLOURINGS)}")
    if not isinstance(states, str) or states not in _STATES:
        raise UsageError(f"unknown states {states!r}", f"objects are drawn {', '.join(_STATES)}")


def _require_seen(batch: Batch, sheet: Sheet) -> None:
    """Raise ExportError where there is nothing to draw, UsageError for affordances on details."""
    if not len(batch):
        raise ExportError("there is no object to draw", "sample at least one")
    if sheet.acting and not words_said(batch, sheet.colour):
        raise ExportError(f"{batch.program.name} has no label of `affordance`", "say where one acts: see `label`")
    if sheet.acting and sheet.details is not None:
        raise UsageError("affordances are drawn on the structure, not on its details", "leave out the details")


def by_pixels(batch: Batch, tile: int) -> Resolution:
    """Meshes whose outlines show no corners in a picture ``tile`` pixels wide, not even of the smallest object."""
    low, high = object_boxes(batch.sites(), len(batch))
    size = (high - low).max(axis=1)
    smallest = float(size[size > 0.0].min(initial=COARSEST))  # some may show nothing
    return Resolution(tolerance=max(_CORNER * smallest / tile, FINEST))


def read_direction(view: str | tuple[float, float] | None) -> tuple[float, float]:
    """Azimuth and elevation (degrees) of a view: a name, two numbers, or the text of two numbers. Raises UsageError."""
    if view is None or isinstance(view, str) and view in VIEWS:
        return VIEWS[view or "iso"]
    try:
        azimuth, elevation = map(float, view.split(",") if isinstance(view, str) else view)
    except (TypeError, ValueError):
        azimuth = elevation = np.nan
    if not (np.isfinite(azimuth) and -90 <= elevation <= 90):
        hint = "an elevation lies between -90 and 90 degrees, as in 120,30"
        raise UsageError(f"unknown view {view!r}: there are {', '.join(VIEWS)}, or an azimuth and an elevation", hint)
    return azimuth, elevation


def draw_legend(tints: dict[str, np.ndarray], width: int) -> np.ndarray:
    """Rows of words beside their colours (3,) uint8, for below a picture of some width."""
    wide, high = 6 * _DOT * (max(map(len, tints), default=0) + 3), 14 * _DOT
    columns = max(1, width // wide)
    strip = np.empty((-(-len(tints) // columns) * high, width, 3), dtype=np.uint8)
    strip[:] = srgb(hex_colour(BACKDROP))
    for k, (word, tint) in enumerate(tints.items()):
        y, x = k // columns * high, k % columns * wide
        strip[y + 2 * _DOT : y + 11 * _DOT, x + 3 * _DOT : x + 12 * _DOT] = tint
        write_text(strip[y : y + 10 * _DOT, x + 14 * _DOT :], word, (60, 66, 74), _DOT)
    return strip


def _side(robots: Robots, pose: tuple[np.ndarray, np.ndarray]) -> float:
    """The side to look from: -1 (the objects' right) if what opens swings to their left, so that one sees inside."""
    turn, shift = pose
    links = robots.links
    moved = rotate(turn, links.translation) + shift - links.translation
    return -1.0 if float(moved[:, 1].mean()) > 1e-3 else 1.0


def default_columns(count: int) -> int:
    """Columns of a sheet somewhat wider than high, with few tiles left empty in its last row."""
    around = np.sqrt(count * 1.3)
    candidates = range(max(1, int(around)), int(around * 1.4) + 2)
    return min(candidates, key=lambda columns: (-count % columns / columns + abs(columns - around) / around, columns))


def write_sheet(batch: Batch, path: Path | str, sheet: Sheet = USUAL, *, force: bool = False, **drawing: Any) -> None:
    """Write the contact sheet of a batch as PNG, ``drawing`` as ``draw_sheet`` takes it."""
    write_bytes(path, png_bytes(draw_sheet(batch, sheet, **drawing)), force=force)
