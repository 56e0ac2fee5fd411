"""Manifests of version 2 that earlier runs have written are read, and written again key by key as they were."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from artipg_dsl.run import manifest as manifests
from artipg_dsl.run.output import Output
from artipg_dsl.run.request import Request

STORED = sorted((Path(__file__).parent / "manifests").glob("2-*.json"))


@pytest.mark.parametrize("path", STORED, ids=lambda path: path.stem)
def test_a_manifest_of_version_2_is_read_and_written_as_it_was(tmp_path: Path, path: Path) -> None:
    shutil.copy(path, tmp_path / manifests.NAME)
    found = manifests.read_manifest(tmp_path)
    assert found is not None
    identity = found["identity"]
    request = Request.from_manifest(identity, found["source"], tmp_path)
    output = Output.from_manifest(identity)
    assert request.objects.size == found["objects"] and request.source == str(tmp_path / found["source"])
    written = request.to_manifest() | output.to_manifest()
    versions = {"artipg_dsl": identity["artipg_dsl"], "numpy": identity["numpy"]}
    if identity["views"] is not None:  # what casts the rays is that of this machine
        written["views"]["engine"] = identity["views"]["engine"]  # type: ignore[typeddict-item]
    assert json.dumps(written | versions, sort_keys=True) == json.dumps(identity, sort_keys=True)
