"""One chain with fine steps throughout, and with coarse ones once sound has crossed it (kernel.arrival)."""

from kernel.method import AFTERWARDS, EXPLICIT, MAX_STEPS, SINGLE_FROM
from kernel.model import Array, Chain
from kernel.run import Run
from kernel.simd import DOUBLE, SINGLE
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import explicit_rule, implicit_rule
from kernel.watch import new_watch


def both_ways(method: int, chain: Chain, V: float, accuracy: float) -> tuple[tuple[Run, Array], tuple[Run, Array]]:
    """Both runs, by EXPLICIT or IMPLICIT, with their crests."""
    fine, hasty = (_run(method, chain, V, accuracy, after) for after in (accuracy, max(AFTERWARDS, accuracy)))
    return fine, hasty


def _run(method: int, chain: Chain, V: float, accuracy: float, after: float) -> tuple[Run, Array]:
    watch = new_watch(())
    if method == EXPLICIT:
        one, rule, later = DOUBLE, explicit_rule(chain, accuracy), explicit_rule(chain, after)
        if accuracy >= SINGLE_FROM and chain.spring.stiffness_at(0.0) > 0.0:
            one = SINGLE
        return run_explicit(chain, V, rule, later, MAX_STEPS, 0.0, watch, one), watch.crests
    damped, later_damped = implicit_rule(chain, V, accuracy), implicit_rule(chain, V, after)
    return run_implicit(chain, V, damped, later_damped, MAX_STEPS, watch), watch.crests
