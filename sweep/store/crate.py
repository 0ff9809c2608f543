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

from kernel.version import __version__
from sweep.errors import InputError
from sweep.schema import RESULTS
from sweep.store import table
from sweep.store.export import export
from sweep.store.meanings import meaning, unit

CONTEXT = "https://w3id.org/ro/crate/1.1/context"
PROFILE = "https://w3id.org/ro/crate/1.1"


def crate(path: Path, folder: Path) -> int:
    """Write the folder, which must not exist; how many rows are done. InputError where it cannot be written."""
    if os.path.lexists(folder):
        raise InputError(f"{folder}: exists; give another -o")
    with table.reading(path) as file:
        known = {name: str(text) for name, text in table.attributes(file).items()}
        layout = file[RESULTS].dtype
    names = [name for name in layout.names or () if name != "checksum"]
    try:
        with TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as scratch:
            partial = Path(scratch) / folder.name
            partial.mkdir()
            rows = _fill(partial, path, names, known)
            partial.rename(folder)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from None
    return rows


def _fill(folder: Path, path: Path, columns: list[str], known: dict[str, str]) -> int:
    """Write the crate's files; how many rows are done."""
    shutil.copyfile(path, folder / path.name)
    rows = export(path, folder / "rows.csv")
    (folder / "spec.toml").write_text(known.get("spec", ""), encoding="utf-8")
    told = _metadata(folder, path.name, columns, known, rows)
    (folder / "ro-crate-metadata.json").write_text(json.dumps(told, indent=1), encoding="utf-8")
    return rows


def _metadata(folder: Path, name: str, columns: list[str], known: dict[str, str], rows: int) -> dict[str, Any]:
    kinds = {name: "application/x-hdf5", "rows.csv": "text/csv", "spec.toml": "application/toml"}
    words = {
        name: "the table, as the sweep wrote it: rows, runs and provenance",
        "rows.csv": "the done rows as text; numbers are exact",
        "spec.toml": "what was asked for",
    }
    files = [_file(folder / one, kind, words[one]) for one, kind in kinds.items()]
    variables = [
        {"@id": f"#{one}", "@type": "PropertyValue", "name": one, "description": meaning(one), "unitText": unit(one)}
        for one in columns
    ]
    spec = json.loads(known.get("resolved", "{}"))
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": str(spec.get("name", name)),
        "description": f"A parameter sweep of impact on chains of springs: {rows} rows, computed by bistable-sweep.",
        "datePublished": datetime.now(UTC).date().isoformat(),
        "license": {"@id": "#license"},
        "hasPart": [{"@id": one["@id"]} for one in files],
        "variableMeasured": [{"@id": one["@id"]} for one in variables],
    }
    program = {
        "@id": "#bistable-sweep",
        "@type": "SoftwareApplication",
        "name": "bistable-sweep",
        "softwareVersion": json.loads(known.get("versions", "{}")).get("bistable-sweep", __version__),
    }
    action = {
        "@id": "#sweep",
        "@type": "CreateAction",
        "name": "sweep run",
        "instrument": {"@id": program["@id"]},
        "object": [{"@id": "spec.toml"}],
        "result": [{"@id": name}],
    }
    licence = {
        "@id": "#license",
        "@type": "CreativeWork",
        "name": "not chosen yet",
        "description": "Who deposits the data names its licence here.",
    }
    about = {
        "@id": "ro-crate-metadata.json",
        "@type": "CreativeWork",
        "conformsTo": {"@id": PROFILE},
        "about": {"@id": "./"},
    }
    return {"@context": CONTEXT, "@graph": [about, root, *files, *variables, program, action, licence]}


def _file(path: Path, kind: str, words: str) -> dict[str, Any]:
    with path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    size = str(path.stat().st_size)
    return {
        "@id": path.name,
        "@type": "File",
        "description": words,
        "encodingFormat": kind,
        "contentSize": size,
        "sha256": digest,
    }
