"""Fill the page's template: one file that holds its rows, its scripts and Bokeh itself."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypedDict

import pandas as pd
from markupsafe import Markup

from analysis.colours import PLAIN_CMAP, RATIO_CMAP
from analysis.look import MARK
from analysis.page.columns import needed_first, payload
from analysis.part import part_of
from analysis.searched import search_of
from analysis.sought import words
from analysis.template import template
from kernel.version import __version__
from sweep.errors import InputError
from sweep.files import as_text

HERE = Path(__file__).parent
SCRIPTS = ("data", "scales", "cells", "paint", "plot", "controls", "readout", "scene", "main")
BOKEH = ("bokeh.min.js", "bokeh-api.min.js")


class Live(TypedDict):
    """What a page knows of the server that answers for it."""

    token: str
    version: str  # of what the page was made with
    table: int  # its number: another one where the file holds another table


def build(table: pd.DataFrame, name: str, live: Live | None = None, part: str = "", made: str = "") -> str:
    """The page of a table, as text.

    Parameters
    ----------
    table : pandas.DataFrame
        All rows, as `analysis.load(path, done_only=False)` gives them.
    name : str
        What the page calls the table.
    live : Live, optional
        The server that answers for this page; None for a page that stands alone.
    part : str
        What the page says of the sweep of which the table is a part.
    made : str
        What it says of the chain and of how it was computed (`analysis.chain.made_of`).
    """
    held, name = payload(table), as_text(Path(name))
    columns = held.pop("columns")
    data = [(column["name"], column.pop("data")) for column in columns]
    facts = held | {"name": name, "columns": columns, "live": live, "colours": _colours()}
    return template("analysis.page").render(
        mark=MARK,
        version=__version__,
        name=name,
        live=live is not None,
        part=part,
        made=made,
        style=Markup((HERE / "page.css").read_text(encoding="utf-8")),
        facts=Markup(_json(facts)),
        first=[pair for pair in data if needed_first(pair[0])],
        later=[pair for pair in data if not needed_first(pair[0])],
        bokeh=[Markup(_script(path.read_text(encoding="utf-8"))) for path in _bokeh()],
        scripts=Markup("\n".join((HERE / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS)),
    )


def part_on_page(path: str | Path, table: pd.DataFrame) -> dict[str, str]:
    """What a table is a part of, but for the counts that the page tells itself; and how a robust search counts."""
    part = {word: text for word, text in part_of(path, table, table).items() if word not in ("pending", "failed")}
    if by := words(search_of(path)):
        part["robust"] = f"The search counts the {by} of an impact; here every row is one impact alone."
    return part


def _bokeh() -> list[Path]:
    """Bokeh's scripts. Found without importing it, which takes a second."""
    found = find_spec("bokeh")
    if found is None or not found.submodule_search_locations:
        raise InputError("a page needs bokeh, which is not installed: pip install bokeh")
    folder = Path(found.submodule_search_locations[0]) / "server" / "static" / "js"
    return [folder / name for name in BOKEH]


def _json(facts: dict[str, Any]) -> str:
    """JSON that may stand in a page: no text in it can end the script."""
    return json.dumps(facts, allow_nan=False).replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _script(text: str) -> str:
    """A library's script without what ends a script, and without the address of its source map."""
    lines = (line for line in text.splitlines() if not line.startswith("//# sourceMappingURL"))
    return "\n".join(lines).replace("</script", "<\\/script")


def _colours() -> dict[str, list[str]]:
    """The house's two rows of colours: for a ratio, and for any other column. Both serve every colour vision."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    names = {"ratio": RATIO_CMAP, "plain": PLAIN_CMAP}
    return {key: [to_hex(colormaps[cmap](k)) for k in range(colormaps[cmap].N)] for key, cmap in names.items()}
