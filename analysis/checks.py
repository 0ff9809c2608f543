"""Arguments of the public functions, checked before anything is computed."""

from collections.abc import Sequence

import pandas as pd

from analysis.errors import InputError
from kernel.hints import did_you_mean, shown, unknown
from kernel.task import is_number_of_model
from sweep.schema import PARAMETERS

FLAGS = ("chaotic", "checked")  # True, False, or missing where nobody looked
TEXT = ("status", "law", "against")


def require(df: object, columns: Sequence[str], name: str = "df") -> None:
    """Raise InputError, naming every problem, unless `df` is a frame that has these columns and they can be used.

    FLAGS must hold flags, TEXT text, every other column numbers; `checked` and `status` also where not asked for.
    """
    if not isinstance(df, pd.DataFrame):
        raise InputError(f"{name}: must be a pandas data frame, got {type(df).__name__}")
    problems = []
    if missing := [column for column in columns if column not in df]:
        there = list(map(str, df.columns))
        hints = "".join(f"; {column}{hint}" for column in missing if (hint := did_you_mean(column, there)))
        observed = any(name.endswith("_ratio") and name != "ke_ratio" for name in missing)
        more = "; q_ratio is there where the spec observes the quantity q" if observed and not hints else ""
        problems.append(f"lacks the columns {', '.join(missing)}{hints}{more}")
    asked = [column for column in (*columns, "checked", "status") if column in df]
    once = [column for column in dict.fromkeys(asked) if isinstance(df[column], pd.Series)]
    if twice := [column for column in dict.fromkeys(asked) if column not in once]:
        problems.append(f"has the columns {', '.join(twice)} more than once")
    for kind, holds in (("numbers", _numbers), ("True, False or nothing", _flags), ("text", _text)):
        mine = [column for column in once if _kind(column) == kind]
        if wrong := [column for column in mine if not holds(df[column])]:
            problems.append(f"must hold {kind} in the columns {', '.join(wrong)}")
    if problems:
        raise InputError(f"the table {'; it '.join(problems)}")


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


def _kind(column: str) -> str:
    return {**dict.fromkeys(FLAGS, "True, False or nothing"), **dict.fromkeys(TEXT, "text")}.get(column, "numbers")


def _numbers(column: "pd.Series[float]") -> bool:
    kind = pd.api.types
    return bool(kind.is_numeric_dtype(column) and not kind.is_bool_dtype(column) and not kind.is_complex_dtype(column))


def _flags(column: "pd.Series[bool]") -> bool:
    return bool(pd.api.types.is_bool_dtype(column)) or bool(column.dropna().isin([True, False]).all())


def _text(column: "pd.Series[str]") -> bool:
    return all(isinstance(value, str) for value in column.dropna().unique())
