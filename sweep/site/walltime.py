"""Until when a run may go on: what the user says, or the scheduler."""

import re
import time
from collections.abc import Mapping
from datetime import datetime, timedelta

from sweep.errors import InputError
from sweep.log import say
from sweep.schema import TIME_MAX
from sweep.site import schedulers

UNTIL_FORMS = 'must be a duration (90m, 1h30m, 1:30:00, 2-00:00:00), a time (17:30, 2030-01-31T17:30) or "none"'
# Seconds before the scheduler's end by which a run is over, or a share of what is left to a short job.
MARGIN, MARGIN_SHARE = 60.0, 0.1
UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}


def deadline(until: str | None, environment: Mapping[str, str], now: float) -> float | None:
    """Seconds since 1970 after which nothing may run, None where nothing limits; InputError for a bad `until`."""
    if until is not None:
        return None if until.strip().lower() == "none" else _checked(until, _instant(until.strip(), now), now)
    end = schedulers.end(environment)
    if end is None and (job := schedulers.job(environment)):
        say(f"nobody tells when job {job} ends: without --until this run does not stop before a limit")
    return None if end is None else end - min(MARGIN, MARGIN_SHARE * max(0.0, end - now))


def _checked(until: str, instant: float | None, now: float) -> float:
    if instant is None or not instant < TIME_MAX:
        raise InputError(f"--until: {UNTIL_FORMS}, got {until!r}")
    if instant <= now:
        raise InputError(f"--until: must lie in the future, got {until!r}")
    return instant


def _instant(text: str, now: float) -> float | None:
    try:
        if (seconds := _duration(text)) is not None:
            return now + seconds
        if re.fullmatch(r"\d{1,2}:\d{2}", text):
            clock = datetime.strptime(text, "%H:%M").time()
            instant = datetime.combine(datetime.fromtimestamp(now).date(), clock)
            return (instant if instant.timestamp() > now else instant + timedelta(days=1)).timestamp()
        return datetime.fromisoformat(text).timestamp() if "-" in text else None
    except (ValueError, OverflowError, OSError):
        return None


def _duration(text: str) -> float | None:
    """Seconds of 90m, 1h30m or [days-]hours:minutes:seconds."""
    if re.fullmatch(r"(\d+(\.\d+)?[smhd])+", text, re.ASCII):
        return sum(float(number) * UNITS[unit] for number, unit in re.findall(r"([\d.]+)([smhd])", text))
    if found := re.fullmatch(r"(?:(\d+)-)?(\d+):([0-5]\d):([0-5]\d)", text, re.ASCII):
        days, hours, minutes, seconds = (int(part or 0) for part in found.groups())
        return float(((days * 24 + hours) * 60 + minutes) * 60 + seconds)
    return None


def as_text(instant: float) -> str:
    """For the log."""
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(instant))
