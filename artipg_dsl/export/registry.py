"""The formats that objects can be written in. A new one is one entry here and one file beside it.

The entries name what writes them as ``module:function``, so that a list of formats costs no import.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

from ..extras import H5PY, PYARROW, ZARR, Package
from ..records import dataclass
from .write import ExportError

if TYPE_CHECKING:
    from ..robot.robots import Robots
    from ..runtime.batch import Batch
    from .containers import Arrays
    from .content import Content


@dataclass(frozen=True, slots=True)
class Container:
    """What arrays are kept in. ``write`` makes the bytes of a file; ``needs`` as of a format."""

    title: str
    suffix: str
    write: str
    needs: Package | None = None


_NPZ = Container("NumPy", ".npz", "containers:npz_bytes")
OTHERS = {
    "hdf5": Container("HDF5", ".h5", "containers:hdf5_bytes", H5PY),
    "zarr": Container("Zarr", ".zarr.zip", "containers:zarr_bytes", ZARR),
    "parquet": Container("Parquet", ".parquet", "containers:parquet_bytes", PYARROW),
}
"""The containers that a format is written in instead, by what follows its name: ``points.hdf5``."""


@dataclass(frozen=True, slots=True)
class Format:
    """What is written and by whom. A format has one of ``shard``, ``robot`` and ``member``.

    ``shard(batch, content)``: what one file for a run of objects holds of some of them, in rows that follow one another: arrays,
    which go into the ``container``, or lines of text. The file is named ``<kind>-<shard><suffix>``.
    ``robot(robot)``: the files of one object, bytes by path relative to its folder. ``member(robots, i)``: the same
    where more than the model of links and joints is needed. ``file`` is one of these files that is always there; ``tells``
    one that no other format has, where that is another. ``clears``: what another format has left and this one does not have.
    ``needs``: what the writer imports beyond what is always installed.
    """

    name: str
    title: str
    suffix: str = ""
    shard: str = ""
    robot: str = ""
    member: str = ""
    file: str = ""
    tells: str = ""
    clears: tuple[str, ...] = ()
    needs: Package | None = None
    seen: bool = False  # it has what is seen alone, nothing that collides or weighs
    weighs: bool = True  # what collides has masses, and joints what follows from them
    container: Container | None = None
    pack: bool = False  # the arrays hold much that repeats
    frame: str = ""  # the shipped frame by which objects lie as in the data set that it follows

    @property
    def kind(self) -> str:
        """What is written, whatever it is kept in: ``points`` of ``points.hdf5``."""
        return self.name.partition(".")[0]

    @property
    def mark(self) -> str:
        """The file of an object's folder that tells whether the format is there."""
        return self.tells or self.file

    @property
    def per_object(self) -> bool:
        """Whether each object gets files of its own."""
        return not self.shard

    def shard_bytes(self, batch: Batch, content: Content) -> bytes:
        """One file for all objects of a batch."""
        return self.joined([self.part(batch, content)])

    def part(self, batch: Batch, content: Content) -> Arrays | bytes:
        """What the file of a shard holds of some of its objects."""
        return _writer(self.shard)(batch, content)

    def joined(self, parts: Sequence[Arrays | bytes]) -> bytes:
        """One file for objects that were made in several parts."""
        if self.container is None:
            return b"".join(cast("Sequence[bytes]", parts))
        return _writer(self.container.write)(_writer("containers:join")(parts), pack=self.pack)

    def files(self, robots: Robots, i: int) -> dict[str, bytes]:
        """The files of object ``i``. Raises ExportError where the format cannot state what the object does."""
        return _writer(self.member)(robots, i) if self.member else _writer(self.robot)(robots.robot(i))


def _writer(place: str) -> Any:
    module, function = place.split(":")
    return getattr(import_module(f".{module}", __package__), function)


TABLES = "tables"
_BARE = ".bare"  # ends the name of a format without meshes


def _contained(entry: Format) -> list[Format]:
    """A format of arrays, and the same in other containers."""
    if entry.container is None or entry.name == TABLES:  # what is read again is kept in one container
        return [entry]
    return [entry] + [
        replace(
            entry,
            name=f"{entry.name}.{name}",
            title=entry.title.replace(entry.container.title, other.title),
            suffix=other.suffix,
            container=other,
            needs=other.needs,
        )
        for name, other in OTHERS.items()
    ]


FORMATS: dict[str, Format] = {
    entry.name: entry
    for plain in (
        Format(
            "points", "labelled points with their binding, NumPy", ".npz", shard="shards:points_shard", container=_NPZ
        ),
        Format(
            "tables",
            "the values alone that all else is made of, NumPy",
            ".npz",
            shard="shards:tables_shard",
            container=_NPZ,
        ),
        Format(
            "annotation", "joints, parts, grasps, parameters as JSON lines", ".jsonl", shard="shards:annotation_shard"
        ),
        Format(
            "views",
            "images and partial clouds from cameras, NumPy",
            ".npz",
            shard="shards:views_shard",
            container=_NPZ,
            pack=True,
        ),
        Format("trace", "how each object was made from another, JSON lines", ".jsonl", shard="mutants:trace_shard"),
        Format(
            "correspondence",
            "which primitive became which, NumPy",
            ".npz",
            shard="mutants:correspondence_shard",
            container=_NPZ,
        ),
        Format("urdf", "robot description with OBJ meshes", robot="urdf:urdf_files", file="object.urdf"),
        Format("mjcf", "MuJoCo's own, with a scene to look at", robot="mjcf:mjcf_files", file="object.xml"),
        Format("sdf", "SDFormat with OBJ meshes, for Gazebo", robot="sdf:sdf_files", file="model.sdf"),
        Format("usd", "OpenUSD with a physics articulation", member="usd:usd_files", file="object.usda"),
        Format("glb", "binary glTF with an opening animation", robot="glb:glb_files", file="object.glb", seen=True),
        Format(
            "obj", "Wavefront OBJ per link with materials", robot="mesh_obj:obj_files", file="obj/object.mtl", seen=True
        ),
        Format(
            "partnet-mobility",
            "the folder of PartNet-Mobility",
            member="partnet.mobility:partnet_files",
            file="mobility.urdf",
            tells="mobility_cvx.urdf",
            weighs=False,
            frame="partnet",
        ),
        Format(
            f"partnet-mobility{_BARE}",
            "the same without meshes",
            member="partnet.mobility:bare_files",
            file="mobility.urdf",
            clears=("mobility_cvx.urdf", "mobility_vhacd.urdf", "textured_objs"),
            seen=True,
            frame="partnet",
        ),
    )
    for entry in _contained(plain)
}
DEFAULT = ("points", "annotation")


def kinds(names: Sequence[str]) -> list[str]:
    """What formats write, whatever it is kept in."""
    return [FORMATS[name].kind for name in names]


def object_formats() -> list[str]:
    """Names of the formats that write files for each object."""
    return [name for name, entry in FORMATS.items() if entry.per_object]


def find_formats(names: str | Sequence[str]) -> list[Format]:
    """Formats by name, ``"urdf,glb"`` or a list, in the order of the registry; ``hdf5`` is short for ``points.hdf5``. Raises
    ExportError.

    A name that is not known is told before any work is done; so is, as a UserError, a package that is not installed.
    """
    wanted = [name.strip() for name in (names.split(",") if isinstance(names, str) else names)]
    wanted = [f"{DEFAULT[0]}.{name}" if name in OTHERS else name for name in wanted if name]
    if not wanted:
        raise ExportError("no format given", f"the formats are {', '.join(FORMATS)}")
    for name in wanted:
        if name not in FORMATS:
            close = get_close_matches(name.lower(), FORMATS, n=1)
            meant = f"did you mean {close[0]}? " if close else ""
            raise ExportError(f"unknown format {name!r}", f"{meant}the formats are {', '.join(FORMATS)}")
        needs = FORMATS[name].needs
        if needs is not None:
            needs.require(name)
        if name.removesuffix(_BARE) != name and name.removesuffix(_BARE) in wanted:
            raise ExportError(f"{name} has the files of {name.removesuffix(_BARE)}", "choose one of the two")
    return [entry for name, entry in FORMATS.items() if name in wanted]


def other_form(name: str) -> str:
    """The format, if there is one, that has the same files with or without meshes: a folder has one of the two."""
    return name.removesuffix(_BARE) if name.endswith(_BARE) else f"{name}{_BARE}"


def without_meshes(formats: Sequence[Format]) -> list[Format]:
    """The same formats, those of objects without their meshes. Raises ExportError."""
    known = [name.removesuffix(_BARE) for name in FORMATS if name.endswith(_BARE)]
    for entry in formats:
        if entry.per_object and entry.name.removesuffix(_BARE) not in known:
            raise ExportError(f"{entry.name} always has meshes", f"--no-meshes is for {', '.join(known)}")
    if not any(entry.per_object for entry in formats):
        raise ExportError("none of the formats has meshes to leave out", f"--no-meshes is for {', '.join(known)}")
    return [FORMATS[f"{entry.name.removesuffix(_BARE)}{_BARE}"] if entry.per_object else entry for entry in formats]


def choose_formats(names: str | Sequence[str] | None, *, views: bool = False) -> list[Format]:
    """What ``apgc sample`` writes: the formats named (None: the default ones), and annotations with any of them but tables, which
    hold them in short.

    ``views``: those too, whether they are named or not.
    """
    chosen = find_formats(DEFAULT if names is None else names)
    if not views and [entry.name for entry in chosen] == [TABLES]:
        return chosen
    more = {"annotation", *(["views"] if views and "views" not in [entry.kind for entry in chosen] else [])}
    return [entry for entry in FORMATS.values() if entry in chosen or entry.name in more]
