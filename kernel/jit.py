"""The one place that knows numba's flags."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])

# Each relaxation by name; never fastmath=True, whose nnan and ninf delete the tests that catch a blow-up.
# contract: fused multiply-add. nsz: -0 equals +0 here. arcp: division by a constant becomes a product.
FASTMATH = {"contract", "nsz", "arcp"}


def jit(function: F) -> F:
    """Compile `function`; it must not touch Python objects, so the GIL is released while it runs."""
    decorate: Any = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH)
    compiled: F = decorate(function)
    return compiled
