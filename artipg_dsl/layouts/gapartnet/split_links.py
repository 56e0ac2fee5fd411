"""A folder's URDF with leaves of its links as links of their own, held by fixed joints: handles that are parts by themselves."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence


def split_links(urdf: bytes, semantics: str, leaves: Sequence[tuple[int, int]]) -> tuple[bytes, str]:
    """The texts of ``mobility.urdf`` and ``semantics.txt`` with each of ``leaves``, (link, leaf) by id, on a new link.

    New links are numbered after those that there are. What is seen keeps its frame, and what collides its link.
    """
    root = ET.fromstring(urdf)
    links = {link.attrib["name"]: link for link in root.iter("link")}
    lines = semantics.splitlines()
    for number, (link, leaf) in enumerate(leaves, len(links) - 1):  # base has no number
        old, new = links[f"link_{link}"], ET.Element("link", name=f"link_{number}")
        for visual in [v for v in old.findall("visual") if v.attrib["name"].endswith(f"-{leaf}")]:
            old.remove(visual)
            new.append(visual)
        root.insert(number + 1, new)
        joint = ET.SubElement(root, "joint", name=f"joint_{number}", type="fixed")
        ET.SubElement(joint, "origin", xyz="0 0 0")
        ET.SubElement(joint, "child", link=f"link_{number}")
        ET.SubElement(joint, "parent", link=f"link_{link}")
        lines.append(f"link_{number} static handle")
    ET.indent(root, "\t")
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" ?>\n{text}\n'.encode(), "".join(f"{line}\n" for line in lines)
