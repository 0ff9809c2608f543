"""How a run ended: a code in the compiled code, a word in the table, a sentence for people."""

DONE, NOT_FINITE, STEP_BUDGET, STEP_TOO_SMALL, ERROR, BAD_INPUT, NOT_CONVERGED = range(7)

WORDS = ("done", "not_finite", "step_budget", "step_too_small", "error", "bad_input", "not_converged")

SENTENCES = {
    "done": "finished",
    "not_finite": "the state stopped being finite, or the watched site has not moved when the run ends",
    "step_budget": "the step budget was spent before the end of the run",
    "step_too_small": "the tolerance asked for a step below the resolution of time",
    "error": "the kernel raised an exception, which the run printed",
    "not_converged": "the target was not reached; the row has the best value and its error",
    "bad_input": "a parameter breaks its rule",
}
