"""Laws from outside of the kernel: whether the compiled code can do with what they are made of."""

import re
from typing import Any

from numba.core import config
from numba.core.errors import NumbaError

from kernel.jit import jit
from kernel.simd import element, splat

RULE = "must do with +, -, *, /, abs and kernel.elementary, as it is given several strains at once"


@jit
def excess_of_pack(spring: Any, e: float) -> float:
    """Its tension beyond the linear spring's, as the integrators ask for it."""
    return float(element(spring.excess(splat(e)), 0))


def problem_of_excess(spring: Any) -> str:
    """What the method `excess` of a spring law uses that is not known of packed strains; empty where all is."""
    if vars(config)["DISABLE_JIT"] or type(spring).__module__.startswith("kernel."):
        return ""
    try:
        excess_of_pack(spring, 0.0)
    except NumbaError as error:
        names = re.findall(r"Function\(<(?:built-in function|ufunc) '?(\w+)", str(error)) or ["another statement"]
        place = re.search(r'File "(.*)", line (\d+):', str(error))
        where = f" ({place[1]}, line {place[2]})" if place else ""
        return f"spring: its method excess {RULE}, got {names[0]}{where}"
    return ""
