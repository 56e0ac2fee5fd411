"""NPCS and ANCSH read back as their loader does, and compared with the model."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..clouds import norms, similarity_error
from ..entry import SPLITS, Entry
from ..findings import Findings, read_vertices, read_xml
from ..hdf5 import read_h5
from ..pth import read_plain_pickle
from .files import LEAST, Frame, Subject, object_names, subjects

if TYPE_CHECKING:
    from ...runtime.batch import Batch

_NEAR = 5e-3  # of a part's diagonal


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as the loader does, and compare with the model."""
    assert entry.term is not None
    name, data = entry.term.name, entry.term.data
    factors, corners = (read_plain_pickle(folder / f"pickle/{name}{end}.pkl") for end in ("", "_corners"))
    lists = [folder / f"splits/{name}/{n}/{split}.txt" for n in data["experiments"] for split in SPLITS]
    lines = {line for path in lists for line in path.read_text("utf-8").splitlines()}
    names = object_names(entry)
    for subject, frames in subjects(batch, entry.term):
        number = int(batch.numbers[subject.i])
        token = names[number]
        place = f"{name}/{token}"
        own = set(
            (folder / f"splits/{name}/{data['experiments'][0]}/{entry.split(number)}.txt").read_text("utf-8").split()
        )
        found.of(place, (folder / "render" / name / token).is_dir(), "no folder in render/, where loaders look for it")
        if found.of(place, token in factors and token in corners, "not in the pickles of all objects"):
            _check_sizes(place, factors[token], corners[token], subject, found)
        _check_urdf(place, folder / "urdf" / name / token, subject, found)
        for frame in frames:
            path = f"hdf5/{place}/{frame.place}.h5"
            found.of(path, path in own, "not in the list of its split")
            found.of(path, "." not in path[:-3], "a dot in its path, at which loaders cut names")
            _check_frame(path, read_h5(folder / path), frame, subject, found)
        for line in sorted(line for line in lines if f"/{token}/" in line):
            found.of(line, (folder / line).is_file(), "in a list, but not there")


def _check_sizes(place: str, factors: Any, corners: Any, subject: Subject, found: Findings) -> None:
    model = subject.corners()
    read = np.array(corners, dtype=np.float64)
    if not found.of(place, read.shape == (len(model), 2, 1, 3), f"corners of shape {read.shape}"):
        return
    found.near(place, "corners of the boxes", read[:, :, 0], model, 1e-9)
    found.near(place, "factors", np.array(factors) * norms(read[:, 1, 0] - read[:, 0, 0]), np.ones(len(model)), 1e-9)


def _check_urdf(place: str, folder: Path, subject: Subject, found: Findings) -> None:
    """As loaders read it: by names; they take the number of files beside the URDF for that of links."""
    beside = len(list(folder.iterdir())) - 1
    found.of(place, beside == len(subject.links), f"{beside} files beside the URDF, not one for each link")
    root = read_xml(folder / "syn.urdf")
    links = {0 if e.attrib["name"] == "base_link" else int(e.attrib["name"]): e for e in root.iter("link")}
    if not found.of(place, sorted(links) == list(range(len(subject.links))), "links are not base_link, 1, 2 ..."):
        return
    for part, link in links.items():
        origin, mesh = link.find("visual/origin"), link.find("visual/geometry/mesh")
        if found.of(place, origin is not None and mesh is not None, f"link {part} has nothing to see"):
            assert origin is not None and mesh is not None
            found.near(place, f"minus the pivot of link {part}", _three(origin, "xyz"), -subject.pivots[part], 1e-8)
            file = folder / mesh.attrib["filename"].rpartition("/")[2]
            found.near(place, f"mesh of link {part}", read_vertices(file), subject.shapes[part].vertices, 1e-8)
    for joint in root.iter("joint"):
        parent, child = map(int, joint.attrib["name"].split("_"))
        found.of(place, parent == subject.parent(child), f"joint {parent}_{child} hangs on another part")
        for tag, what, model in (
            ("origin", "xyz", subject.pivots[child] - subject.pivots[parent]),
            ("axis", "xyz", subject.joints[child - 1].axis),
        ):
            element = joint.find(tag)
            if found.of(place, element is not None, f"joint {parent}_{child} has no {tag}"):
                assert element is not None
                found.near(place, f"{tag} of joint {parent}_{child}", _three(element, what), model, 1e-8)


def _three(element: ET.Element, name: str) -> np.ndarray:
    return np.array(element.attrib[name].split(), dtype=np.float64)


def _check_frame(path: str, read: dict[str, np.ndarray], frame: Frame, subject: Subject, found: Findings) -> None:
    """Against the model, and what loaders do not notice."""
    corners = subject.corners()[1:]
    parts = len(subject.links)
    named = {f"{group}/{k}" for group in ("gt_points", "gt_coords") for k in range(parts)} | {"rgb", "mask"}
    if not found.of(path, set(read) == named, f"holds {', '.join(sorted(read))}"):
        return
    found.same(path, "pixels of the mask", read["mask"], frame.mask)
    found.same(path, "colours", read["rgb"], frame.rgb)
    found.of(path, int(read["mask"].sum()) == sum(map(len, frame.points)), "the mask shows other points")
    for k in range(parts):
        points, coords = (read[f"{group}/{k}"].astype(np.float64) for group in ("gt_points", "gt_coords"))
        found.of(path, len(points) >= LEAST, f"{len(points)} points of part {k}")
        found.near(path, f"points of part {k}", points, frame.points[k], 1e-6)
        found.near(path, f"coordinates of part {k}", coords, frame.coords[k], 1e-6)
        if points.shape != coords.shape or len(points) < 3:
            continue
        low, high = corners[k]
        size = float(norms(high - low))
        off = float(max((low - coords).max(), (coords - high).max())) / size
        found.of(path, off < _NEAR, f"part {k} reaches {off:.3f} beyond its box: normalised coordinates leave 0 .. 1")
        off = similarity_error(coords, points) / size
        found.of(path, off < _NEAR, f"coordinates of part {k} are not its points moved: {off:.4f} off")
        spread = [norms(placed.std(axis=0)) for placed in (coords, points)]
        found.of(path, abs(float(spread[0] - spread[1])) < _NEAR * size, f"part {k} has another size in the view")
