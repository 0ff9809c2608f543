// Only where a server answers (analysis view): new rows as they come, and the impact of a picked row.

class Server {
  constructor({ token, version, table }) {
    Object.assign(this, { token, version, table }); // of what the page was made with
  }

  async ask(path) {
    const answer = await fetch(`${path}${path.includes("?") ? "&" : "?"}token=${encodeURIComponent(this.token)}`);
    const found = await answer.json();
    if (!answer.ok) throw new Error(found.problem || answer.statusText);
    return found;
  }

  // Calls `grown` with the rows whenever what the table tells has changed. Of another table nothing is shown: its rows
  // would stand among those that were kept, and below this one's heading.
  async follow(grown, lost) {
    for (;;) {
      await new Promise((resume) => setTimeout(resume, 1500));
      try {
        let told = await this.ask("/version");
        if (told.table === this.table && told.version !== this.version) {
          told = await this.ask("/rows");
          if (told.table === this.table) await grown(told);
          this.version = told.version;
        }
        if (told.table !== this.table) {
          return lost("The file holds another table by now: this page shows the one before. Load it anew to see the other.");
        }
        lost(told.problem && `The page shows what it had: ${told.problem}.`);
      } catch (error) {
        lost(`The server does not answer (${error.message}): the page shows what it had.`);
      }
    }
  }
}

function small(title, x, y) {
  const figure = P.figure({
    title, x_axis_label: x, y_axis_label: y, height: 300, sizing_mode: "stretch_width", tools: "pan,box_zoom,reset",
  });
  figure.toolbar.logo = null;
  for (const axis of [...figure.xaxes, ...figure.yaxes]) axis.axis_label_text_font_style = "normal";
  return figure;
}

function spaceTime(ke, law, palette) {
  const shape = ke.shape, top = Math.log10(Math.max(ke.high, 1e-300)), bottom = top - 5;
  const colours = new Colours(palette, bottom, top, true), pixels = new Uint32Array(shape[0] * shape[1]);
  ke.values.forEach((x, k) => { pixels[k] = packed(colours.of(x > 0 ? x : 10 ** bottom)); });
  const figure = small(`${law} chain: KE of its sites over TE`, "site", "time over N");
  figure.x_range = new Bokeh.Range1d({ start: 0.5, end: ke.N + 0.5 });
  figure.y_range = new Bokeh.Range1d({ start: 0, end: ke.t_end });
  const source = new Bokeh.ColumnDataSource({
    data: { image: [NDARRAY(pixels, shape)], x: [0.5], y: [0], dw: [ke.N], dh: [ke.t_end] },
  });
  const field = (name) => ({ field: name });
  figure.image_rgba(field("image"), field("x"), field("y"), field("dw"), field("dh"), { source });
  const mapper = new Bokeh.LinearColorMapper({ palette, low: bottom, high: top });
  const ticks = numbersOnScale("log", bottom, top), ticker = new Bokeh.FixedTicker({ ticks: ticks.map(Math.log10) });
  const bar = new Bokeh.ColorBar({ color_mapper: mapper, ticker, width: 12 });
  bar.major_label_overrides = new Map(ticks.map((x) => [Math.log10(x), x.toExponential(0)]));
  figure.add_layout(bar, "right");
  return figure;
}

// Lines of both chains: solid and dashed, so that they are told apart without colours.
function lines(title, x, y, where, drawn) {
  const figure = small(title, x, y);
  if (where === "below") { // the axes: long words beside many curves would cover some wherever they stood
    figure.add_layout(new Bokeh.Legend(), "below");
    figure.height += 90;
  }
  for (const [label, xs, ys, color, dash] of drawn) {
    figure.line(xs, ys, { line_color: color, line_dash: dash, line_width: 2, legend_label: label });
  }
  figure.legend.label_text_font_size = "12px";
  figure.legend.padding = 4;
  if (where !== "below") figure.legend.location = where;
  return figure;
}

const BLACK = "#000000", ORANGE = "#D55E00", BLUE = "#0072B2";

// `wanted` tells whether these pictures still are: another impact may have been picked since.
async function drawScene(found, palette, wanted) {
  const place = document.getElementById("scene-pictures");
  place.replaceChildren();
  const both = [["bistable", found.bistable], ["linear", found.linear]];
  const figures = both.map(([law, run]) => spaceTime(run.ke, law, palette));
  figures.push(lines("energies", "time over N", "energy over TE", "below", both.flatMap(([law, run], k) => [
    [`${law}: in the chain and impactor`, run.t, run.total, BLACK, k ? "dashed" : "solid"],
    [`${law}: taken by the dampers`, run.t, run.dissipated, ORANGE, k ? "dashed" : "solid"],
  ])));
  figures.push(lines(`velocities at t/N = ${found.at}`, "site", "velocity over the sound speed", "top_right", both.map(([law, run], k) =>
    [law, run.site, run.v, k ? BLUE : BLACK, k ? "dashed" : "solid"])));
  for (const figure of figures) {
    if (!wanted()) return;
    const box = element("div", { className: "small" });
    place.append(box);
    await P.show(figure, box);
  }
}
