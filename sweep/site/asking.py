"""Ask the commands of a scheduler, with an end to the waiting."""

import shutil
import subprocess
from collections.abc import Sequence

ANSWER_WITHIN = 20.0  # seconds: some commands try for ten before they say that nobody answers
UNTRIED = "jobs can be submitted from here (sweep submit); this was never tried on a real one"


def called(command: Sequence[str], within: float | None = None) -> "subprocess.CompletedProcess[str]":
    """The command once it has ended; OSError or subprocess.TimeoutExpired where it cannot start, or takes longer.

    Names of other people's jobs need not be text in our encoding.
    """
    return subprocess.run(command, capture_output=True, text=True, errors="replace", check=False, timeout=within)


def answer(*command: str, within: float = ANSWER_WITHIN) -> str:
    """What the command prints; OSError or subprocess.SubprocessError where it fails, or takes longer."""
    told = called(command, within)
    told.check_returncode()
    return told.stdout


def reached(needed: Sequence[str], question: Sequence[str], who: str) -> tuple[bool, str]:
    """Whether the command `question` was answered, and what it printed; or in words why jobs cannot be submitted.

    needed: all commands that submitting takes; who: must answer, in words.
    """
    if missing := [name for name in needed if shutil.which(name) is None]:
        return False, f"no {', '.join(missing)}: jobs cannot be submitted from here"
    try:
        told = called(question, ANSWER_WITHIN)
    except subprocess.TimeoutExpired:
        return False, f"{who} does not answer within {ANSWER_WITHIN:g} s: jobs cannot be submitted now"
    except OSError as error:
        return False, f"{question[0]} cannot be run ({error.strerror}): jobs cannot be submitted from here"
    if told.returncode:
        why = (told.stderr.strip().splitlines() or [f"exit status {told.returncode}, without a reason"])[-1]
        return False, f"{who} cannot be reached, jobs cannot be submitted now: {why}"
    return True, told.stdout
