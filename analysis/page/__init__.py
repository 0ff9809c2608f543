"""Any table as one HTML file that needs no network: `build` for the text, `payload` for the rows that it holds.

`columns` packs the rows, `html` fills the template; the scripts beside them run in the browser, `main.js` last. What
draws is Bokeh (axes, scales, colour bar, zoom); which row a cell shows is decided in `cells.js`.
"""

from analysis.page.columns import payload as payload
from analysis.page.html import Live as Live
from analysis.page.html import build as build
from analysis.page.html import part_on_page as part_on_page
