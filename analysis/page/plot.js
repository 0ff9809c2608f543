// The picture: Bokeh's axes, colour bar and zoom around an image that `paint` makes for what is in view.

const P = Bokeh.Plotting;
const NDARRAY = (values, shape) => Bokeh.require("core/util/ndarray").ndarray(values, { shape, dtype: "uint32" });

const NEAREST = 1e-9; // of an axis: digits of its numbers would end below

// A text in lines of at most so many letters.
function wrapped(text, most) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const last = lines.length - 1;
    if (lines[last].length + word.length + 1 > most && lines[last]) lines.push(word);
    else lines[last] += (lines[last] ? " " : "") + word;
  }
  return lines;
}

class Plot {
  constructor(place, seen) {
    this.place = place; // the element that holds it
    this.seen = seen; // called with the name of an event, and where it was
    this.key = "";
  }

  // A new figure where the axes have changed, the same one where they have not; in view is what was, of axes that are
  // still there.
  async show(across, up, words) {
    const moved = !across.is(this.across) || !up.is(this.up);
    const key = [across.name, across.scale, up.name, up.scale].join(), view = this.figure ? this.window() : [];
    const follow = (axis, old, shown) => (old?.name === axis.name ? axis.following(old, shown) : [axis.low, axis.high]);
    const [x0, x1] = follow(across, this.across, view.slice(0, 2)), [y0, y1] = follow(up, this.up, view.slice(2));
    this.across = across;
    this.up = up;
    if (key === this.key) {
      if (!moved) return;
      this._range(this.figure.x_range, across, x0, x1);
      this._range(this.figure.y_range, up, y0, y1);
      return;
    }
    this.key = key;
    this.image = new Bokeh.ColumnDataSource({ data: { image: [], x: [], y: [], dw: [], dh: [] } });
    this.mark = new Bokeh.ColumnDataSource({ data: { left: [], right: [], bottom: [], top: [] } });
    const type = (axis) => (axis.scale === "log" ? "log" : "linear");
    const range = (axis, low, high) => this._range(new Bokeh.Range1d(), axis, low, high);
    this.figure = P.figure({
      x_axis_type: type(across), y_axis_type: type(up), x_range: range(across, x0, x1), y_range: range(up, y0, y1),
      sizing_mode: "stretch_both", tools: "pan,box_zoom,wheel_zoom,reset", toolbar_location: "below",
      x_axis_label: words(across.name), y_axis_label: words(up.name), min_border_right: 20,
    });
    this.figure.toolbar.logo = null;
    this.figure.xgrid.visible = this.figure.ygrid.visible = false;
    this.figure.background_fill_color = "#ffffff";
    for (const axis of [...this.figure.xaxes, ...this.figure.yaxes]) {
      axis.axis_label_text_font_style = "normal";
      axis.axis_label_text_font_size = axis.major_label_text_font_size = "13px";
      axis.axis_label_text_color = axis.major_label_text_color = "#1a1a1a";
      axis.minor_tick_line_color = null;
    }
    const field = (name) => ({ field: name });
    this.figure.image_rgba(field("image"), field("x"), field("y"), field("dw"), field("dh"), { source: this.image });
    const sides = [field("left"), field("right"), field("bottom"), field("top")];
    const outline = { source: this.mark, fill_alpha: 0 };
    this.figure.quad(...sides, { ...outline, line_color: "#ffffff", line_width: 5 });
    this.figure.quad(...sides, { ...outline, line_color: "#000000", line_width: 2 });
    this._bar();
    this._listen();
    this.place.replaceChildren();
    this.view = await P.show(this.figure, this.place);
  }

  _bar() {
    this.mapper = new Bokeh.LinearColorMapper({ palette: ["#000000", "#ffffff"], low: 0, high: 1 });
    this.ticker = new Bokeh.FixedTicker({ ticks: [] });
    this.bar = new Bokeh.ColorBar({
      color_mapper: this.mapper, ticker: this.ticker, width: 14, padding: 6,
      major_label_text_font_size: "13px", major_label_text_color: "#1a1a1a",
    });
    this.figure.add_layout(this.bar, "right");
  }

  // The bar shows the colours' own units, evenly: its labels say the numbers.
  colours(colours, words) {
    this.mapper.setv({ palette: colours.palette, low: colours.low, high: colours.high });
    const ticks = numbersOnScale(colours.log ? "log" : "linear", colours.low, colours.high);
    const at = ticks.map((x) => (colours.log ? Math.log10(x) : x)), digits = apart(ticks);
    this.bar.major_label_overrides = new Map(at.map((s, k) => [s, shown(ticks[k], digits)]));
    this.ticker.ticks = at;
    this.words = words;
  }

  _listen() {
    const told = (name) => (event) => {
      if (event.x === undefined) return this.seen(name, null);
      return this.seen(name, { x: this.across.fromBokeh(event.x), y: this.up.fromBokeh(event.y) });
    };
    this.figure.on_event("mousemove", told("over"));
    this.figure.on_event("mouseleave", () => this.seen("away", null));
    this.figure.on_event("tap", told("pick"));
    let asked = false; // several changes of the ranges in one frame are one
    const moved = () => {
      if (asked) return;
      asked = true;
      requestAnimationFrame(() => { asked = false; this.seen("moved", null); });
    };
    for (const range of [this.figure.x_range, this.figure.y_range]) {
      range.properties.start.change.connect(moved);
      range.properties.end.change.connect(moved);
    }
  }

  window() {
    const { x_range, y_range } = this.figure;
    return [
      this.across.fromBokeh(x_range.start), this.across.fromBokeh(x_range.end),
      this.up.fromBokeh(y_range.start), this.up.fromBokeh(y_range.end),
    ];
  }

  // Pixels of the frame within the axes.
  size() {
    const box = this.view && this.view.frame ? this.view.frame.bbox : null;
    return box && box.width > 1 ? [Math.round(box.width), Math.round(box.height)] : [600, 400];
  }

  draw(pixels, width, height, [x0, x1, y0, y1]) {
    const [left, right] = [this.across.toBokeh(x0), this.across.toBokeh(x1)];
    const [bottom, top] = [this.up.toBokeh(y0), this.up.toBokeh(y1)];
    this.image.data = {
      image: [NDARRAY(pixels, [height, width])], x: [left], y: [bottom], dw: [right - left], dh: [top - bottom],
    };
    this._ticks(this.figure.xaxes[0], this.across, x0, x1, width / 55);
    this._ticks(this.figure.yaxes[0], this.up, y0, y1, height / 30);
  }

  _ticks(axis, scale, low, high, most) {
    const ticks = scale.ticks(low, high, Math.max(2, Math.min(MOST_TICKS, Math.floor(most))));
    axis.major_label_overrides = new Map(ticks);
    axis.ticker = new Bokeh.FixedTicker({ ticks: ticks.map(([x]) => x) });
  }

  outline(box) {
    const [x0, x1, y0, y1] = box || [];
    this.mark.data = box
      ? { left: [this.across.toBokeh(x0)], right: [this.across.toBokeh(x1)],
        bottom: [this.up.toBokeh(y0)], top: [this.up.toBokeh(y1)] }
      : { left: [], right: [], bottom: [], top: [] };
  }

  zoom(factor, at) {
    const [x0, x1, y0, y1] = this.window();
    const [x, y] = at || [(x0 + x1) / 2, (y0 + y1) / 2];
    const near = (low, middle) => middle + (low - middle) / factor;
    this._range(this.figure.x_range, this.across, near(x0, x), near(x1, x));
    this._range(this.figure.y_range, this.up, near(y0, y), near(y1, y));
  }

  whole() {
    this._range(this.figure.x_range, this.across, this.across.low, this.across.high);
    this._range(this.figure.y_range, this.up, this.up.low, this.up.high);
  }

  // Shows so much of an axis, though not far beyond all of it, where nothing is and where numbers end; what Bokeh's own
  // "reset" shows is all of it.
  _range(range, axis, low, high) {
    const { least, most } = axis.limits(), [start, end] = [Math.max(low, least), Math.min(high, most)];
    if (!(end - start > (most - least) * NEAREST)) return range;
    const [reset_start, reset_end, ...bounds] = [axis.low, axis.high, least, most].map((s) => axis.toBokeh(s));
    range.setv({ start: axis.toBokeh(start), end: axis.toBokeh(end), reset_start, reset_end, bounds });
    return range;
  }

  // With words above it and below it, as it is looked at without the page.
  picture(above, below) {
    const drawn = this.view.export("png", true).canvas, scale = drawn.width / this.place.clientWidth;
    const lines = (texts) => texts.flatMap((text) => wrapped(text, Math.floor(this.place.clientWidth / 7.5)));
    const [head, foot] = [lines([...above, this.words]), lines(below)], height = 20 * scale;
    const top = (head.length + 0.5) * height, bottom = top + drawn.height;
    const canvas = Object.assign(document.createElement("canvas"), {
      width: drawn.width, height: bottom + (foot.length + 0.5) * height,
    });
    const pen = canvas.getContext("2d");
    pen.fillStyle = "#ffffff";
    pen.fillRect(0, 0, canvas.width, canvas.height);
    pen.fillStyle = "#1a1a1a";
    pen.font = `${13 * scale}px sans-serif`;
    head.forEach((text, k) => pen.fillText(text, 8 * scale, (k + 0.9) * height));
    foot.forEach((text, k) => pen.fillText(text, 8 * scale, bottom + (k + 0.9) * height));
    pen.drawImage(drawn, 0, top);
    return canvas;
  }
}
