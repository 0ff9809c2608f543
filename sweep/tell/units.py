"""Numbers with their units, for people."""

SECONDS = (("d", 86400.0), ("h", 3600.0), ("min", 60.0))
BYTES = (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3))


def duration(seconds: float) -> str:
    """`0.047 s`, `12 min`, `3.4 h`, `41 d`: the largest unit of which there are two."""
    return _in_units(seconds, SECONDS, "s")


def size(count: float) -> str:
    """`636 kB`: a number of bytes, in powers of 1000."""
    return _in_units(count, BYTES, "bytes", 1.0)


def _in_units(value: float, units: tuple[tuple[str, float], ...], smallest: str, least: float = 2.0) -> str:
    name, unit = next(((name, unit) for name, unit in units if value >= least * unit), (smallest, 1.0))
    return f"{three_digits(value / unit)} {name}"


def three_digits(value: float) -> str:
    """Without an exponent where it has at most nine digits before its point."""
    return f"{value:.0f}" if 100 <= abs(value) < 1e9 else f"{value:.3g}"
