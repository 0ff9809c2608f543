"""A table as an RO-Crate: a folder with the table, its rows as text, its spec, and one file that tells of all of them.

RO-Crate 1.1 (researchobject.org) is what repositories of research data read: plain files and `ro-crate-metadata.json`.
"""

import hashlib
import json
import os
import shutil
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote

from kernel.version import __version__
from sweep.errors import InputError, writing
from sweep.schema import RESULTS
from sweep.store import table
from sweep.store.export import columns_of, export
from sweep.store.meanings import meaning, unit

CONTEXT = "https://w3id.org/ro/crate/1.1/context"
PROFILE = "https://w3id.org/ro/crate/1.1"


def crate(path: Path, folder: Path) -> int:
    """Write the folder, which must not exist; how many rows are done. InputError where it cannot be written."""
    if os.path.lexists(folder):
        raise InputError(f"{folder}: exists; give another -o")
    with table.reading(path) as file:
        known, columns = table.attributes(file), columns_of(file[RESULTS].dtype)
    with writing(folder), TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as scratch:
        partial = Path(scratch) / folder.name
        partial.mkdir()
        rows = _fill(partial, path, columns, known)
        partial.rename(folder)
    return rows


def _fill(folder: Path, path: Path, columns: list[str], known: dict[str, str]) -> int:
    """Write the crate's files; how many rows are done."""
    copy = folder / path.name
    shutil.copyfile(path, copy)
    rows = export(copy, folder / "rows.csv")  # a run may go on: the crate's files must tell of one instant
    (folder / "spec.toml").write_text(known.get("spec", ""), encoding="utf-8")
    told = _metadata(folder, path.name, columns, known, rows)
    (folder / "ro-crate-metadata.json").write_text(json.dumps(told, indent=1), encoding="utf-8")
    return rows


def _metadata(folder: Path, name: str, columns: list[str], known: dict[str, str], rows: int) -> dict[str, Any]:
    parts = {
        name: ("application/x-hdf5", "the table, as the sweep wrote it: rows, runs and provenance"),
        "rows.csv": ("text/csv", "the done rows as text; numbers are exact"),
        "spec.toml": ("application/toml", "what was asked for"),
    }
    files = [_file(folder / one, *of) for one, of in parts.items()]
    variables = [
        _entity(f"#{one}", "PropertyValue", name=one, description=meaning(one), unitText=unit(one)) for one in columns
    ]
    root = _entity(
        "./",
        "Dataset",
        name=str(json.loads(known.get("resolved", "{}")).get("name", name)),
        description=f"A parameter sweep of impact on chains of springs: {rows} rows, computed by bistable-sweep.",
        datePublished=datetime.now(UTC).date().isoformat(),
        license=_id("#license"),
        hasPart=[_id(one["@id"]) for one in files],
        variableMeasured=[_id(one["@id"]) for one in variables],
    )
    version = json.loads(known.get("versions", "{}")).get("bistable-sweep", __version__)
    program = _entity("#bistable-sweep", "SoftwareApplication", name="bistable-sweep", softwareVersion=version)
    used = {"instrument": _id(program["@id"]), "object": [_id("spec.toml")], "result": [_id(files[0]["@id"])]}
    action = _entity("#sweep", "CreateAction", name="sweep run", **used)
    deposit = "Who deposits the data names its licence here."
    licence = _entity("#license", "CreativeWork", name="not chosen yet", description=deposit)
    about = _entity("ro-crate-metadata.json", "CreativeWork", conformsTo=_id(PROFILE), about=_id("./"))
    return {"@context": CONTEXT, "@graph": [about, root, *files, *variables, program, action, licence]}


def _file(path: Path, form: str, words: str) -> dict[str, Any]:
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    size = str(path.stat().st_size)
    uri = quote(os.fsencode(path.name))
    return _entity(uri, "File", description=words, encodingFormat=form, contentSize=size, sha256=digest)


def _entity(name: str, kind: str, /, **more: Any) -> dict[str, Any]:
    """One thing that the crate tells of; `name`: its URI, relative to the crate."""
    return {**_id(name), "@type": kind, **more}


def _id(name: str) -> dict[str, str]:
    """How one thing refers to another."""
    return {"@id": name}
