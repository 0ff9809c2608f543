// An axis: from a number to a place on the picture and back. "even" gives every value of a short list the same room.

const MOST_TICKS = 9;

function fitting(table, name) {
  const about = table.about.get(name), { low, above, high } = table.range(name);
  if (about.values && (low <= 0 || about.values.length <= 6)) return "even";
  return low > 0 && high / above >= 20 ? "log" : "linear";
}

function possible(table, name) {
  const about = table.about.get(name), { low, above } = table.range(name);
  const found = ["linear"];
  if (about.values ? low > 0 : above > 0) found.push("log");
  if (about.values && about.values.length <= 200) found.push("even");
  return found;
}

class Axis {
  constructor(table, name, scale) {
    this.table = table;
    this.name = name;
    this.scale = possible(table, name).includes(scale) ? scale : fitting(table, name);
    const values = table.about.get(name).values;
    this.cells = values && table.isNumber(name) ? values.filter((x) => !Number.isNaN(x)) : null;
    this.edges = this.cells ? this._edges() : null;
    [this.low, this.high] = this.edges ? [this.edges[0], this.edges[this.edges.length - 1]] : this._whole();
  }

  // To the scale's own units, in which the picture is even.
  forward(x) {
    return this.scale === "log" ? Math.log10(x) : this.scale === "even" ? this._place(x) : x;
  }

  // Bokeh's axis is logarithmic by itself; "even" is a linear one of places.
  toBokeh(s) {
    return this.scale === "log" ? 10 ** s : s;
  }

  fromBokeh(x) {
    return this.scale === "log" ? Math.log10(x) : x;
  }

  // Of what can be shown: all of the axis, and as much on both sides.
  limits() {
    return { least: 2 * this.low - this.high, most: 2 * this.high - this.low };
  }

  is(other) {
    const same = ["name", "scale", "low", "high"].every((key) => this[key] === other?.[key]);
    return same && this.cells?.length === other.cells?.length && (this.cells || []).every((x, k) => x === other.cells[k]);
  }

  // What of this axis shows the same as [low, high] of the axis before: all of it where that was all, else the same
  // values, which are at other places of a scale that gives every value the same room.
  following(before, [low, high]) {
    const slack = 1e-6 * (before.high - before.low), all = [this.low, this.high], same = this.scale === before.scale;
    if (low <= before.low + slack && high >= before.high - slack) {
      return same ? [this.low + low - before.low, this.high + high - before.high] : all;
    }
    if (same && this.scale !== "even") return [low, high];
    if (!this.edges || !before.edges) return all;
    const found = [low, high].map((s) => {
      const k = Math.min(Math.max(indexBelow(before.edges, s), 0), before.cells.length - 1);
      const here = this.cells.indexOf(before.cells[k]), share = (s - before.edges[k]) / (before.edges[k + 1] - before.edges[k]);
      return this.edges[here] + share * (this.edges[here + 1] - this.edges[here]);
    });
    const seen = found[0] < found[1] && found[0] < this.high && found[1] > this.low; // not where a value is no more
    return seen ? found : all;
  }

  _place(x) {
    const values = this.cells;
    let low = 0;
    while (low < values.length - 1 && values[low + 1] <= x) low++;
    return low + 0.5;
  }

  _edges() {
    const n = this.cells.length;
    if (this.scale === "even") return Float64Array.from({ length: n + 1 }, (_, k) => k);
    const at = this.cells.map((x) => this.forward(x));
    const edges = new Float64Array(n + 1);
    for (let k = 1; k < n; k++) edges[k] = (at[k - 1] + at[k]) / 2;
    const lone = this.scale === "log" ? 0.1 : Math.max(Math.abs(at[0]) / 10, 0.5);
    edges[0] = n > 1 ? at[0] - (edges[1] - at[0]) : at[0] - lone;
    edges[n] = n > 1 ? at[n - 1] + (at[n - 1] - edges[n - 1]) : at[0] + lone;
    return edges;
  }

  _whole() {
    const { low, above, high } = this.table.range(this.name);
    if (Number.isNaN(high)) return [0, 1];
    const from = this.forward(this.scale === "log" ? above : low), to = this.forward(high);
    const margin = to > from ? 0.02 * (to - from) : 0.5;
    return [from - margin, to + margin];
  }

  // Where labels stand between two places, and what they say.
  ticks(low, high, most) {
    if (this.scale === "even") return this._everyFew(low, high, most);
    const numbers = numbersOnScale(this.scale, low, high, most), digits = apart(numbers);
    return numbers.map((x) => [x, shown(x, digits)]);
  }

  _everyFew(low, high, most) {
    const first = Math.max(0, Math.ceil(low - 0.5)), last = Math.min(this.cells.length - 1, Math.floor(high - 0.5));
    const step = Math.max(1, Math.ceil((last - first + 1) / most)), found = [];
    this.digits ||= apart(this.cells, 3);
    for (let k = first; k <= last; k += step) found.push([k + 0.5, shown(this.cells[k], this.digits)]);
    return found;
  }
}

// The last of sorted edges that is no higher than a place; -1 where none is.
function indexBelow(edges, s) {
  let low = -1, high = edges.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (edges[middle] <= s) low = middle; else high = middle;
  }
  return low;
}

// Round numbers between two places of a scale, about `most` of them.
function numbersOnScale(scale, low, high, most = MOST_TICKS) {
  if (scale === "log") {
    for (const digits of [[1, 2, 5], [1, 3], [1]]) {
      const found = logTicks(low, high, digits, 1);
      if (found.length <= most && found.length >= 2) return found;
    }
    if (high - low > 1) return logTicks(low, high, [1], Math.ceil((high - low) / most));
    return linearTicks(10 ** low, 10 ** high, most);
  }
  return linearTicks(low, high, most);
}

function logTicks(low, high, digits, step) {
  const found = [];
  for (let power = Math.max(Math.floor(low), -323); power <= Math.min(high, 308); power++) {
    if (power % step !== 0) continue;
    for (const digit of digits) {
      const x = Number(`${digit}e${power}`), s = Math.log10(x);
      if (s >= low - 1e-9 && s <= high + 1e-9) found.push(x);
    }
  }
  return found;
}

function linearTicks(low, high, most) {
  const rough = (high - low) / Math.max(most - 1, 1), power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((digit) => digit * power).find((one) => one >= rough * 0.999) || power;
  const found = [], first = Math.ceil(low / step);
  if (!(Math.abs(first) < 2 ** 52)) return found; // where numbers lie no closer, or end
  for (let k = first; k * step <= high; k++) found.push(Number((k * step).toPrecision(10)));
  return found;
}
