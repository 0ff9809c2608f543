"""Arguments of the public functions, checked before anything is computed."""

from collections.abc import Sequence

import pandas as pd

from kernel.hints import shown, taken_for, unknown
from kernel.task import is_number_of_model
from sweep.errors import InputError
from sweep.schema import COLUMNS, PARAMETERS

FLAGS = ("chaotic", "checked")  # True, False, or missing where nobody looked
TEXT = ("status", "law", "against")
OPTIONAL = ("checked", "status", "spread_low", "spread_high")  # columns that a frame need not have
OBSERVED = "of a quantity q that the spec observes there are q, q_linear and q_ratio"


def require(df: object, columns: Sequence[str], name: str = "df") -> None:
    """Raise InputError, naming every problem, unless `df` is a frame that has these columns and they can be used.

    FLAGS must hold flags, TEXT text, every other column numbers; OPTIONAL ones also where not asked for.
    """
    if not isinstance(df, pd.DataFrame):
        raise InputError(f"{name}: must be a pandas data frame, got {type(df).__name__}")
    if both := [str(level) for level in df.index.names if level is not None and level in df.columns]:
        raise InputError(f"{name}: must not have {', '.join(both)} in its index and as columns: reset_index(drop=True)")
    problems, there = [], list(map(str, df.columns))
    missing = [column for column in columns if column not in df]
    compared = [column for column in missing if name == "df" and _is_compared(column, columns)]
    if missing := [column for column in missing if column not in {*compared, *map(error_of, compared)}]:
        others = [column for column in there if column not in columns]  # what is needed itself stands for no other
        hints = "".join(f"; {column}{hint}" for column in missing if (hint := taken_for(column, others)))
        problems.append(f"lacks the columns {', '.join(missing)}{hints}")
    asked = [column for column in (*columns, *OPTIONAL) if column in df]
    once = [column for column in dict.fromkeys(asked) if isinstance(df[column], pd.Series)]
    if twice := [column for column in dict.fromkeys(asked) if column not in once]:
        problems.append(f"has the columns {', '.join(twice)} more than once")
    for kind, holds in (("numbers", _numbers), ("True, False or nothing", _flags), ("text", _text)):
        mine = [column for column in once if _kind(column) == kind]
        if wrong := [column for column in mine if not holds(df[column])]:
            problems.append(f"must hold {kind} in the columns {', '.join(wrong)}")
    told = [f"the table {'; it '.join(problems)}"] if problems else []
    known = ["ke_ratio", *(column for column in there if _is_compared(column, there))]
    if told := [*told, *(f"{unknown('of', column, known)}; {OBSERVED}" for column in compared)]:
        raise InputError(*told)


def model_axes(df: pd.DataFrame) -> list[str]:
    """The columns of a frame that are numbers of the model."""
    return [name for name in getattr(df, "columns", ()) if isinstance(name, str) and is_number_of_model(name)]


def inputs(df: pd.DataFrame) -> list[str]:
    """The columns of a frame that say which task a row is: the parameters, and the numbers of the model."""
    return [*PARAMETERS, *model_axes(df)]


def require_one_chain(df: pd.DataFrame, but: Sequence[str] = ()) -> None:
    """Raise InputError where a number of the model varies, `but` these: several chains must not compete as one."""
    if several := [name for name in model_axes(df) if name not in but and len(df[name].unique()) > 1]:
        raise InputError(
            f"the table varies {', '.join(several)}: choose the rows of one chain (--at {several[0]}=VALUE), "
            "or draw a map over them"
        )


def require_numbers_of_model(rows: pd.DataFrame) -> None:
    """Raise InputError where rows lack a number of the model, as in an edited .csv: it tells no chain of theirs."""
    empty = {name: int(rows[name].isna().sum()) for name in model_axes(rows)}
    if problems := [
        f"{count} of {len(rows)} finished rows have no {name}: give it, or choose others (--at {name}=VALUE)"
        for name, count in empty.items()
        if count
    ]:
        raise InputError(*problems)


def choice(name: str, value: object, known: Sequence[str]) -> None:
    """Raise InputError unless `value` is one of `known`."""
    if not isinstance(value, str) or value not in known:
        raise InputError(unknown(name, value, known))


def names(name: str, value: object) -> None:
    """Raise InputError unless `value` is a list of names."""
    if isinstance(value, str) or not isinstance(value, Sequence) or not all(isinstance(one, str) for one in value):
        raise InputError(f"{name}: must be a list of names, got {shown(value)}")


def truth(name: str, value: object) -> None:
    """Raise InputError unless `value` is True or False."""
    if not isinstance(value, bool):
        raise InputError(f"{name}: must be True or False, got {shown(value)}")


def error_of(column: str) -> str:
    """The column of the error of a quantity's value or ratio, as `analysis.quantity` has it."""
    name = column.removesuffix("_ratio").removesuffix("_linear")
    return "error" if name == "ke" else f"{name}_error"


def _is_compared(column: str, columns: Sequence[str]) -> bool:
    """Whether it is the value or the ratio of a quantity that not every table has: its error is among the columns."""
    return column not in COLUMNS and not column.endswith("_error") and error_of(column) in columns


def _kind(column: str) -> str:
    return {**dict.fromkeys(FLAGS, "True, False or nothing"), **dict.fromkeys(TEXT, "text")}.get(column, "numbers")


def _numbers(column: "pd.Series[float]") -> bool:
    kind = pd.api.types
    return bool(kind.is_numeric_dtype(column) and not kind.is_bool_dtype(column) and not kind.is_complex_dtype(column))


def _flags(column: "pd.Series[bool]") -> bool:
    return bool(pd.api.types.is_bool_dtype(column)) or bool(column.dropna().isin([True, False]).all())


def _text(column: "pd.Series[str]") -> bool:
    return all(isinstance(value, str) for value in column.dropna().unique())
