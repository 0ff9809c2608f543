// Colours of numbers, and the picture's pixels.

const RATIO_SPAN = 10; // each side of 1 spans at least this factor, so that small differences do not look large
const INK = [20, 20, 20], NOTHING = [226, 226, 226];

function rgb(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

// low and high in the colours' own units: powers of ten where `log`.
class Colours {
  constructor(palette, low, high, log) {
    Object.assign(this, { palette, low, high, log });
    this.rgb = palette.map(rgb);
    this.ends = log ? [10 ** low, 10 ** high] : [low, high];
  }

  of(x) {
    const at = ((this.log ? Math.log10(x) : x) - this.low) / (this.high - this.low);
    const last = this.rgb.length - 1;
    return this.rgb[at <= 0 ? 0 : at >= 1 ? last : Math.round(at * last)];
  }
}

// For a column of the table, the same for every slice, so that slices can be compared.
function coloursOf(table, of, scale, palettes, cells) {
  if (of === "rows") {
    const most = cells.value.reduce((a, b) => (b > a ? b : a), 1);
    return new Colours(palettes.plain, 0, Math.max(most, 2), false);
  }
  const { low, above, high } = table.range(of);
  if (of.endsWith("_ratio") && scale !== "linear" && above > 0) return ratioColours(palettes.ratio, above, high);
  if (Number.isNaN(high)) return new Colours(palettes.plain, 0, 1, false);
  const log = scale === "log" ? above > 0 : scale === "linear" ? false : low > 0 && high / low >= 20;
  const [from, to] = log ? [Math.log10(above), Math.log10(high)] : [low, high];
  return new Colours(palettes.plain, from, to > from ? to : from + 1, log);
}

// Blue below 1, red above: the palette's middle stands at 1, and each side spans its own range.
function ratioColours(palette, lowest, highest) {
  const low = Math.log10(Math.min(lowest, 1 / RATIO_SPAN)), high = Math.log10(Math.max(highest, RATIO_SPAN));
  const last = palette.length - 1;
  const warped = Array.from({ length: 512 }, (_, k) => {
    const s = low + ((high - low) * k) / 511;
    return palette[Math.round((s < 0 ? 0.5 * (1 - s / low) : 0.5 + (0.5 * s) / high) * last)];
  });
  return new Colours(warped, low, high, true);
}

// width x height pixels of the window [x0, x1] x [y0, y1] (places of the axes), from the bottom up: what Bokeh takes.
function paint(table, cells, colours, state, [x0, x1, y0, y1], width, height) {
  const columns = lookup(cells.across.edges, x0, x1, width), lines = lookup(cells.up.edges, y0, y1, height);
  const colour = coloursOfCells(cells, colours);
  const marks = marksOfCells(table, cells, state);
  const pixels = new Uint32Array(width * height), ink = packed(INK);
  for (let j = 0; j < height; j++) {
    if (lines[j] < 0) continue;
    const first = lines[j] * cells.across.count;
    for (let i = 0; i < width; i++) {
      if (columns[i] < 0) continue;
      const cell = first + columns[i], mark = marks[cell];
      pixels[j * width + i] =
        mark & 1 && (i + j) % 9 < 2 ? ink : mark & 2 && i % 6 < 2 && j % 6 < 2 ? ink : colour[cell];
    }
  }
  return pixels;
}

function packed([r, g, b]) {
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
}

// The cell of every pixel along one side; -1 outside.
function lookup(edges, low, high, pixels) {
  const found = new Int32Array(pixels).fill(-1), last = edges.length - 1;
  let cell = 0;
  for (let k = 0; k < pixels; k++) {
    const s = low + ((high - low) * (k + 0.5)) / pixels;
    while (cell < last && edges[cell + 1] <= s) cell++;
    if (s >= edges[0] && cell < last) found[k] = cell;
  }
  return found;
}

// Cells of a grid that hold rows without a number are grey; places where no row is stay empty.
function coloursOfCells(cells, colours) {
  const found = new Uint32Array(cells.value.length), nothing = packed(NOTHING);
  for (let cell = 0; cell < found.length; cell++) {
    const x = cells.value[cell];
    if (x === x && !(colours.log && x <= 0)) found[cell] = packed(colours.of(x));
    else if (cells.rows[cell]) found[cell] = nothing;
  }
  return found;
}

// 1: hatched, chaotic; 2: dotted, its estimated error is above the wanted.
function marksOfCells(table, cells, state) {
  const found = new Uint8Array(cells.value.length), of = table.errorOf(state.of);
  const error = table.has(of) ? table.numbers(of) : null;
  for (let cell = 0; cell < found.length; cell++) {
    const row = cells.row[cell];
    if (cells.chaotic[cell]) found[cell] |= 1;
    if (error && row >= 0 && error[row] > state.error) found[cell] |= 2;
  }
  return found;
}
