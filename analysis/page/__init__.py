"""`analysis paper`: every figure and number of the paper beside ours, on one page that needs no network."""

from analysis.page.build import NAME, Page, build, pictures

__all__ = ["NAME", "Page", "build", "pictures"]
