"""The parts of the documentation that follow from the code: spec keys, columns, quantities, commands, reference.

Run by conf.py before each build, into docs/_generated, so that no such part can say what the code does not do.
"""

import argparse
import inspect
import json
import re
import shutil
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import draw_parts
from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticUndefined

import analysis
import kernel
import sweep
from analysis.cli import parser as analysis_parser
from kernel.along import Disordered, Graded
from kernel.lattice import Model
from kernel.laws import SPRINGS, Hertz
from kernel.observers import OBSERVERS, Largest
from kernel.quantities import QUANTITIES
from kernel.status import SENTENCES
from sweep.cli import parser as sweep_parser
from sweep.errors import EXIT_STATUS
from sweep.plan.asked import LEFT_OUT, WORST, Sought
from sweep.plan.points import POINTS_MAX, SAMPLES
from sweep.plan.problems import problem_line
from sweep.plan.spec import Spec, _keys
from sweep.schema import PARAMETERS, ROW, RUN_COLUMNS
from sweep.store.meanings import meaning, unit
from tests import measured

ROOT = Path(__file__).parent.parent
# None of these is a good value of any key: the validator answers with its rule.
BAD_VALUES: tuple[Any, ...] = ("?", -1, 1e99, 10**18, "", "x" * 999, 0)
KINETIC = "What every table has, asked for or not: ke_bistable, ke_linear, ke_ratio, and when these peaks are."
FREE = ("axes", "points", "model")  # fields that the validator takes whole
MINIMAL = {"N": [5, 8, 13], "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": 1.0}


def everything(folder: Path) -> None:
    """Write all generated parts into the folder, in place of what was there."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    parts = {
        "spec.md": spec_keys(),
        "columns.md": columns(),
        "observers.md": observers(),
        "statuses.md": statuses(),
        "sweep-commands.md": commands(sweep_parser()),
        "analysis-commands.md": commands(analysis_parser()),
        "kernel.rst": reference(kernel),
        "sweep.rst": reference(sweep),
        "analysis.rst": reference(analysis),
        "exit.md": f"{EXIT_STATUS}\n",
    }
    for path in sorted(measured.FOLDER.glob("*.json")):
        parts[f"measured-{path.stem}.md"] = f"{measured.markdown(path.stem)}\n{measured.source(path.stem)}\n"
    for name, text in parts.items():
        (folder / name).write_text(text, encoding="utf-8")
    for picture in ("jobs/quick.png", "jobs/paper/fig4.png", "tests/tradeoff.png", "tests/atlas.png"):
        shutil.copy(ROOT / picture, folder)
    shutil.copy(ROOT / "tests/peers/work-precision.png", folder)
    draw_parts.draw(folder / "parts.png")


def table(head: list[str], rows: list[list[str]]) -> str:
    """In Markdown; a bar in a cell would end it."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', '¦') for cell in line)} |\n" for line in lines) + "\n"


def spec_keys() -> str:
    """Every key: whether it is needed, what the validator says of a value that is none, and what its source says."""
    plain, sections = dict[str, Any](), dict[str, type[BaseModel]]()
    for name, field in Spec.model_fields.items():
        if name in FREE:
            continue
        model = _model(field.annotation)
        if model is None:
            plain[name] = field
        else:
            sections[name] = model
    text = "## Before all sections\n\n" + _keys_table(Spec, plain, ())
    for name, model in sections.items():
        needed = "needed, unless there is `[points]`" if name == "grid" else "may be left out"
        text += f"## `[{name}]`: {needed}\n\n{inspect.getdoc(model) or ''}\n\n"
        text += _keys_table(model, dict(model.model_fields), (name,))
    return text + _of_model() + _of_points()


def _of_model() -> str:
    """The numbers of a model with their defaults, and the laws of its springs with theirs."""
    text = "## `[model]`: may be left out\n\nThe chain; absent, the paper's. Every number of it can be an axis of "
    text += '`[grid]`, as `"spring.c2" = { linear = [4, 5], points = 3 }` or `"mass.seed" = [1, 2, 3]`, and is then a '
    text += "column of that name, which takes the place of what stands here.\n\n"
    said, paper = dict(_parameters(Model)), Model().settings()
    numbers = {"spring": 'a table: `law = "bistable"` and its numbers, below', "contact": _numbers(Hertz)}
    fields = [
        [f"`{name}`", numbers.get(name, f"`{json.dumps(value)}`"), said.get(name, "")] for name, value in paper.items()
    ]
    laws = [
        [f'`"{name}"`', _numbers(law), (inspect.getdoc(law) or "").splitlines()[0]] for name, law in SPRINGS.items()
    ]
    head = ["numbers and what they are if left out", "meaning"]
    text += table(["key", "if left out", "meaning"], fields) + table(["`law` of `spring`", *head], laws)
    along = [[f"`{_braced(form)}`", (inspect.getdoc(form) or "").splitlines()[0]] for form in (Graded, Disordered)]
    along += [["`[1.0, 1.1, 0.9]`", "one number for each site, all chains of this length"]]
    return text + table(["mass, stiffness or damping, if no number", "meaning"], along)


def _numbers(law: type) -> str:
    """Of a law: each of its numbers as a spec would set it."""
    found = inspect.signature(law).parameters.values()
    return ", ".join(
        f"`{one.name}` needed" if one.default is one.empty else f"`{one.name} = {one.default}`" for one in found
    )


def _braced(form: Any) -> str:
    """As a spec has it."""
    return f"{{ {', '.join(f'{name} = ..' for name in form._fields)} }}"


def _of_points() -> str:
    """What may stand in [points]."""
    samples = ", ".join(f'"{name}"' for name in SAMPLES)
    rows = [
        ["`file`", "a CSV file whose columns are named as in `[grid]`, one task a line"],
        ["`sample`", f"instead of it: {samples}, with `n`, `seed` and the ranges of the axes"],
    ]
    about = f"## `[points]`: instead of `[grid]`\n\nTasks that form no grid, at most {POINTS_MAX}.\n\n"
    return about + table(["key", "meaning"], rows)


def _parameters(documented: type) -> list[tuple[str, str]]:
    """The names and words of the numpydoc section of parameters; names that share words stand on one line."""
    section = (inspect.getdoc(documented) or "").partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    found = re.findall(r"^(\S[^:\n]*) : .*\n((?:    .*\n?)+)", section, re.MULTILINE)
    return [(name, " ".join(words.split())) for names, words in found for name in names.split(", ")]


def _model(annotation: Any) -> type[BaseModel] | None:
    """The section that a field of the spec is; None where it is a plain key."""
    for one in (annotation, *typing.get_args(annotation)):
        if inspect.isclass(one) and issubclass(one, BaseModel):
            return one
    return None


def _keys_table(model: type[BaseModel], fields: dict[str, Any], place: tuple[str, ...]) -> str:
    said = _comments(model)
    rows = []
    for name, field in fields.items():
        default = "needed" if field.default is PydanticUndefined and field.default_factory is None else ""
        default = default or f"`{json.dumps(_left_out(model, name, field))}`"
        words = said.get(name) or (meaning(name) if name in PARAMETERS else "")
        rows.append([f"`{name}`", default.replace("`null`", "none"), _rule((*place, name)), words])
    return table(["key", "if left out", "rule", "meaning"], rows)


def _left_out(model: type[BaseModel], name: str, field: Any) -> Any:
    """What a key is where it is left out; that of a search depends on what it looks for."""
    known = {"by": WORST} | {
        key: value for keys in LEFT_OUT.values() for key, value in keys.items() if value is not None
    }
    return known[name] if model is Sought and name in known else field.get_default(call_default_factory=True)


def _rule(place: tuple[str, ...]) -> str:
    """What the validator itself says to values that are none."""
    said = dict.fromkeys(rule for bad in BAD_VALUES if (rule := _refusal(place, bad)))
    exact = [rule for rule in said if not rule.startswith("must be a valid ")] or list(said)
    whole = ["must be a whole number"] if "must be a valid integer" in said and exact != list(said) else []
    return "; ".join([*whole, *exact])


def _refusal(place: tuple[str, ...], bad: Any) -> str:
    """The rule in the message for this value; nothing where the value is good."""
    document: dict[str, Any] = {"name": "example", "grid": dict(MINIMAL)}
    home = document if len(place) == 1 else document.setdefault(place[0], {})
    home[place[-1]] = bad
    try:
        Spec.model_validate(document)
    except ValidationError as error:
        for problem in error.errors():
            if tuple(map(str, problem["loc"][: len(place)])) == place:
                line = problem_line(problem, _keys()).partition(": ")[2]
                return re.split(r"[,;] got ", line)[0]
    return ""


def _comments(model: type[BaseModel]) -> dict[str, str]:
    """Of every key what the source says beside it, or above."""
    found, above = dict[str, str](), list[str]()
    for line in inspect.getsource(model).splitlines():
        text = line.strip()
        if text.startswith("#"):
            above.append(text.lstrip("# "))
            continue
        if match := re.match(r"(\w+): .*?(?:\s+# (.*))?$", text):
            found[match[1]] = " ".join([*above, match[2] or ""]).strip()
        above = []
    return found


def columns() -> str:
    """Every column of a table that holds the kinetic energy alone."""
    rows = []
    for name in ROW.names or ():
        kind = {"f": "number", "i": "whole number", "u": "whole number", "b": "flag", "S": "text"}[ROW[name].kind]
        words = meaning(name) + (f", in {unit(name)}" if unit(name) not in ("", "1") else "")
        rows.append([f"`{name}`", kind, words + ("; may differ between two runs" if name in RUN_COLUMNS else "")])
    return table(["column", "kind", "what it is"], rows)


def laws() -> str:
    """Every law of springs and the contact's, as docs/model.md has them: it is read where nothing is generated, too."""
    rows = []
    for name, law in [*((f'`law = "{name}"`', law) for name, law in SPRINGS.items()), ("`contact`", Hertz)]:
        said, found = dict(_parameters(law)), inspect.signature(law).parameters.values()
        left_out = {one.name: "needed" if one.default is one.empty else f"{one.default:.4g}" for one in found}
        numbers = " ".join(f"`{key}` ({default}): {said[key]}" for key, default in left_out.items())
        rows.append([name, numbers, (inspect.getdoc(law) or "").splitlines()[0]])
    return table(["law", "numbers (in brackets: if left out)", "what it is; e: strain, tension over k_T L"], rows)


def quantities() -> str:
    """Every quantity that `observe` may name, as docs/model.md has them."""
    rows = [["`peak_ke`, or `ke`", "TE", KINETIC]]
    for name, one in QUANTITIES.items():
        first = (inspect.getdoc(type(one)) or "").splitlines()[:1]
        rows.append([f"`{name}`", str(one.unit()), " ".join(first)])
    return table(["quantity", "unit", "what it is"], rows)


def observers() -> str:
    """What a scene can record."""
    rows = [
        [f"`{name}`", _options(kind) or "none", " ".join((inspect.getdoc(kind) or "").split())]
        for name, kind in OBSERVERS.items()
    ]
    rows.append(["any quantity of the table above", "none", " ".join((inspect.getdoc(Largest) or "").split())])
    return table(["observer", "options, and what they are if left out", "what it records: array (shape)"], rows)


def _options(kind: type) -> str:
    """Of an observer: each of its options as a scene would set it."""
    found = [one for name, one in inspect.signature(kind).parameters.items() if name != "scene"]
    return ", ".join(f"`{one.name} = {'all' if one.default is None else one.default}`" for one in found)


def statuses() -> str:
    """How a row can have ended."""
    return table(["status", "meaning"], [[f"`{word}`", sentence] for word, sentence in SENTENCES.items()])


def commands(top: argparse.ArgumentParser) -> str:
    """What every command answers to --help."""
    text = ""
    for name, command in _subcommands(top):
        text += f"### `{top.prog} {name}`\n\n```text\n{_help(command)}\n```\n\n"
    return text


def _help(command: argparse.ArgumentParser) -> str:
    command.formatter_class = lambda prog: argparse.HelpFormatter(prog, width=100)  # type: ignore[assignment]
    return command.format_help().strip()


def _subcommands(top: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for action in top._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from action.choices.items()


def reference(package: Any) -> str:
    """Every public name of a package, by its docstring, and the package's own classes that its functions return."""
    text, public = "", [getattr(package, name) for name in package.__all__ if not name.startswith("__")]
    for one in public:
        kind = "autoexception" if inspect.isclass(one) and issubclass(one, Exception) else "autofunction"
        kind = "autoclass" if kind == "autofunction" and inspect.isclass(one) else kind
        name, home = one.__name__, one.__module__.partition(".")[0]
        if home == package.__name__:
            text += f".. {kind}:: {home}.{name}\n\n"
        else:  # described there
            text += f".. py:{kind.removeprefix('auto')}:: {package.__name__}.{name}\n\n   :py:obj:`{home}.{name}`\n\n"
        for kind_of in (kind for kind in _returned(one) if kind not in public):
            text += f".. autoclass:: {kind_of.__module__}.{kind_of.__name__}\n\n"
    return text


def _returned(function: Any) -> list[type]:
    """The classes of its own package that a function returns, alone, in a list, or where it returns something."""
    if inspect.isclass(function):
        return []
    told = function.__annotations__.get("return")
    ours = function.__module__.partition(".")[0]
    return [kind for kind in (told, *typing.get_args(told)) if getattr(kind, "__module__", "").startswith(f"{ours}.")]


if __name__ == "__main__":
    everything(Path(__file__).parent / "_generated")
