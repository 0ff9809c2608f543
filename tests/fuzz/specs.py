"""Specs as a hurried or malicious hand would write them, and command lines likewise."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from sweep.errors import InputError
from sweep.plan.spec import Spec, read_spec
from sweep.prepare import Options, prepare
from sweep.serve.pulse import Pulse
from sweep.store import table
from tests.fuzz.judge import ACCEPTED, FILES, WRONG, Told, judged, tried

GOOD = """name = "good"
[grid]
N = { log = [5, 8], points = 2 }
zeta_T = [0, 1e-3]
M_over_M0 = 1.0
V_over_V0 = { linear = [0.3, 3], points = 3 }
[accuracy]
target = 1e-2
method = "auto"
certify = true
max_steps = 1000000
[output]
observe = ["peak_ke"]
flush_every = 30
"""
KEYS = ("name", "grid", "N", "zeta_T", "M_over_M0", "V_over_V0", "accuracy", "target", "method", "rtol", "atol")
KEYS += ("max_steps", "certify", "output", "observe", "flush_every", "log", "linear", "points", "", "ключ", "a.b")
TOKENS = ("[", "]", "{", "}", "=", ",", '"', "'", '"""', "\n", "#", ".", "-", "+", "_", "e", "inf", "nan", "true", "\0")
TOKENS += ("\\u", "\x1b[31m", "\u202e", "\ufeff", "\r", "1979-05-27T07:32:00Z", "0x", "1e999", "9" * 25, "[[", "]]")
NUMBERS = (0, -1, 1, 2, 1.5, 1e-300, 5e-324, 1e308, -0.0, 2**31, 2**63 - 1, -(2**63), 2**64, 10**400, 10_000)
USUAL = ("1", "2", "7", "0.1", "1e-3", "1e-2", "[2, 3, 4]", "[0.1, 0.2]", "{ log = [2, 9], points = 3 }")
TASKS_MAX = 20_000  # of an accepted spec whose table is made


def texts(rng: np.random.Generator) -> str:
    """A string of any kind, as TOML."""
    letters = rng.choice([*TOKENS, "a", " ", "b" * 100], rng.integers(6))
    return '"' + "".join(f"\\U{ord(c):08x}" if not c.isalnum() else c for text in letters for c in text) + '"'


def value(rng: np.random.Generator, depth: int = 0) -> str:
    """A value of any kind, as TOML; often a usual one."""
    if depth == 0 and rng.random() < 0.4:
        return str(rng.choice(USUAL))
    kind = int(rng.integers(9 if depth < 4 else 5))
    if kind < 2:
        return repr(NUMBERS[int(rng.integers(len(NUMBERS)))])
    if kind == 2:
        return repr(float(rng.choice([np.nan, np.inf, -np.inf, rng.normal() * 10.0 ** rng.integers(-12, 12)])))
    if kind == 3:
        return str(
            rng.choice(["true", "false", "1979-05-27", "07:32:00", "1979-05-27T07:32:00Z", '"auto"', '"peak_ke"'])
        )
    if kind == 4:
        return texts(rng)
    items = [value(rng, depth + 1) for _ in range(int(rng.integers(4)))]
    if kind < 7:
        return f"[{', '.join(items)}]"
    if kind == 7:
        ends, points = [value(rng, 3) for _ in range(2)], int(rng.choice([0, 1, 2, 3, 7, 100, 10**4, 10**7]))
        return f"{{ {rng.choice(['log', 'linear'])} = [{', '.join(ends)}], points = {points} }}"
    return "{ " + ", ".join(f'"{rng.choice(KEYS)}{i}" = {item}' for i, item in enumerate(items)) + " }"


def random_bytes(rng: np.random.Generator) -> bytes:
    """No text at all, or one of a few letters."""
    size = int(rng.integers(1, 400))
    return rng.bytes(size) if rng.random() < 0.3 else "".join(rng.choice([*TOKENS, "a", "1", " "], size)).encode()


def mutated(rng: np.random.Generator) -> bytes:
    """A good spec with slips of the pen."""
    text = list(GOOD)
    for _ in range(int(rng.integers(1, 3))):
        at, what = int(rng.integers(len(text))), int(rng.integers(6))
        if what == 0:
            del text[at : at + int(rng.choice([1, 2, 20, len(text)]))]
        elif what == 1:
            text[at:at] = str(rng.choice(TOKENS))
        elif what == 2:
            text[at] = chr(int(rng.integers(1, 0x2FFF)))
        elif what == 3:
            text[at:at] = text[at : at + int(rng.integers(1, 60))]
        elif what == 4:
            text[at:at] = str(rng.choice(KEYS))
        else:
            text[at : at + 1] = rng.choice(list("0123456789.e-"), 1)
        text = text or ["a"]
    return "".join(text).encode("utf-8", "surrogatepass")


def other_values(rng: np.random.Generator) -> bytes:
    """Sound TOML with values, keys and sections that nobody asked for."""
    lines = GOOD.splitlines()
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(len(lines)))
        key = lines[at].partition(" =")[0]
        what = rng.random()
        if what < 0.7 and "[" not in key:
            lines[at] = f"{key} = {value(rng)}"
        elif what < 0.85:
            lines.insert(at, f'"{rng.choice(KEYS)}" = {value(rng)}')
        else:
            lines[at] = f"[{rng.choice(KEYS[:9])}]"
    return "\n".join(lines).encode()


def spec_case(make: Callable[[np.random.Generator], bytes]) -> Callable[[np.random.Generator, Path], Told]:
    """A case: a spec made by `make`, given to one of the commands that read specs."""

    def case(rng: np.random.Generator, folder: Path) -> Told:
        path, out = folder / "spec.toml", folder / "t.h5"
        path.write_bytes(make(rng))
        try:
            spec, _ = read_spec(path)
        except InputError:
            commands = (["run", path, "-o", out], ["plan", path], ["submit", path, "--dry-run"])
            return judged([*map(str, commands[int(rng.integers(3))])], folder, {2})
        except BaseException as error:
            return tried(error)
        if rng.random() < 0.1 and spec.tasks <= TASKS_MAX:
            return judged(["plan", str(path)], folder, {0})
        if rng.random() < 0.1 or spec.tasks > TASKS_MAX:
            return judged(["submit", str(path), "--dry-run", "--ranks", "2", "--time", "10"], folder, {0})
        return _made(spec, path, out)

    return case


def _made(spec: Spec, path: Path, out: Path) -> Told:
    """The table of an accepted spec is whole and holds the spec's tasks."""
    from contextlib import ExitStack

    try:
        with ExitStack() as stack:
            prepare(None, Options(path, out), stack, stack.enter_context(Pulse(None)))
        tasks = spec.task_list()
        with table.reading(out) as file:
            rows = file["results"][()]
    except BaseException as error:
        return tried(error)
    same = all((rows[name] == column).all() for name, column in tasks.columns(np.arange(len(tasks))).items())
    left = sorted(each.name for each in out.parent.iterdir())
    if left != ["spec.toml", "t.h5"]:
        return FILES, f"left behind: {left}"
    return (ACCEPTED, "") if same and len(rows) == spec.tasks else (WRONG, "the table holds other tasks")


OPTIONS = ("--until", "--shard", "--max-fails", "--writer", "--reuse", "--keep-rows", "--recompute", "--retry-failed")
OPTIONS += ("--repair", "--json", "--fraction", "--array", "--ranks", "--time", "--partition", "--sbatch", "--all")
WORDS = ("", "0", "-1", "1/2", "2/1", "9" * 30, "nan", "inf", "90m", "25:61", "none", "2999-01-01", "0001-01-01")
WORDS += (".", "t.h5", "spec.toml", "missing", "a\nb", "\udcff", "x" * 300, "1e9d", "1h1h1h", "²", "٣", "--", "-o")
WORDS += ("99999999-00:00:00", "/dev/null", "\x1b[31m")
COMMANDS = ("plan", "submit", "status", "show", "merge", "export", "audit", "doctor", "fly")


def arguments(rng: np.random.Generator, folder: Path) -> Told:
    """A good spec, no table, and a command line of any kind; --dry-run keeps `submit` from writing."""
    (folder / "spec.toml").write_text(GOOD)
    command = str(rng.choice(COMMANDS))
    words = [str(rng.choice(WORDS)) for _ in range(int(rng.integers(3)))]
    for _ in range(int(rng.integers(4))):
        words += [str(rng.choice(OPTIONS)), *([str(rng.choice(WORDS))] if rng.random() < 0.8 else [])]
    if command == "doctor":
        words = ["missing", *words]
    fixed = {"submit": ["--dry-run", "--ranks=1", "--time=1", "spec.toml"], "plan": ["spec.toml"]}.get(command, [])
    return judged([command, *fixed, *words], folder, {0, 2})


def run_arguments(rng: np.random.Generator, folder: Path) -> Told:
    """The same for `run`: with a table that is no table, so that nothing is computed."""
    (folder / "spec.toml").write_text(GOOD)
    (folder / "t.h5").write_text("no table")
    words = []
    for _ in range(int(rng.integers(1, 5))):
        words += [str(rng.choice(OPTIONS[:9])), *([str(rng.choice(WORDS))] if rng.random() < 0.8 else [])]
    return judged(["run", "spec.toml", *words, "-o", "t.h5"], folder, {2})


KINDS = {
    "spec: random bytes": spec_case(random_bytes),
    "spec: slips of the pen": spec_case(mutated),
    "spec: other values": spec_case(other_values),
    "command line": arguments,
    "command line of run": run_arguments,
}
