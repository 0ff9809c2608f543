"""`python -m analysis paper`: every figure and number of the paper beside ours, on one page that needs no network."""

from analysis.page.build import Page, build

__all__ = ["Page", "build"]
