// Which row, or which number, every cell of the picture shows.

const CALM_FIRST = "calm first", LEFT_OUT = "left out", LIKE_OTHERS = "like others";
const CHAOTIC = 1;

// For every number its place among `count` equal bins between low and high (places of the axis); -1 outside.
function bins(axis, numbers, low, high, count) {
  const found = new Int32Array(numbers.length);
  const log = axis.scale === "log", per = count / (high - low);
  for (let row = 0; row < numbers.length; row++) {
    const at = ((log ? Math.log10(numbers[row]) : numbers[row]) - low) * per;
    found[row] = at >= 0 && at < count ? at : -1;
  }
  return found;
}

// A grid over the picture: the cells of the axis' values, or bins of so many pixels between low and high. `at` finds
// the place of a number, -1 where it has none.
function gridOf(axis, low, high, pixels, size) {
  if (axis.edges) {
    const { cells, edges } = axis;
    return { axis, index: axis.table.array(axis.name), count: cells.length, edges, at: (x) => cells.indexOf(x) };
  }
  const count = Math.max(1, Math.floor(pixels / size));
  const edges = Float64Array.from({ length: count + 1 }, (_, k) => low + ((high - low) * k) / count);
  const at = (x) => bins(axis, [x], low, high, count)[0];
  return { axis, index: bins(axis, axis.table.numbers(axis.name), low, high, count), count, edges, at };
}

// state: {of, take: lowest, highest or mean, chaos, slices: [[name, value; null: all], ..]}; what every cell shows: `value` (nan:
// nothing), `row` (-1: none, or more than one), `rows` that fell into it, `summed`: how many of these a mean is of,
// `chaotic`: 1 where nothing calm did, `left`: how many chaotic ones the user leaves out.
function cellsOf(table, state, across, up) {
  const size = across.count * up.count;
  const value = new Float64Array(size).fill(NaN), row = new Int32Array(size).fill(-1);
  const rows = new Uint32Array(size), summed = new Uint32Array(size), left = new Uint32Array(size);
  const chaotic = new Uint8Array(size);
  const numbers = state.of === "rows" ? null : table.numbers(state.of);
  const chaos = table.array("chaotic"), wanted = selected(table, state);
  const sign = state.take === "highest" ? -1 : 1, mean = state.take === "mean";
  for (let r = 0; r < table.rows; r++) {
    if (wanted && !wanted[r]) continue;
    const i = across.index[r], j = up.index[r];
    if (i < 0 || j < 0 || i >= across.count || j >= up.count) continue; // codes of what is not known come last
    const cell = j * across.count + i, x = numbers ? numbers[r] : 1;
    rows[cell]++;
    if (x !== x) continue;
    if (chaos[r] === CHAOTIC && state.chaos === LEFT_OUT) { left[cell]++; continue; }
    const wild = numbers && state.chaos !== LIKE_OTHERS && chaos[r] === CHAOTIC ? 1 : 0;
    const empty = summed[cell] === 0;
    if (!empty && wild > chaotic[cell]) continue;
    if (empty || wild < chaotic[cell]) {
      value[cell] = x; row[cell] = r; chaotic[cell] = wild; summed[cell] = 1;
    } else {
      summed[cell]++;
      if (mean || !numbers) value[cell] += x;
      else if (sign * x < sign * value[cell]) { value[cell] = x; row[cell] = r; }
    }
  }
  for (let cell = 0; cell < size; cell++) {
    if (mean && numbers && summed[cell] > 1) { value[cell] /= summed[cell]; row[cell] = -1; }
    if (!numbers && summed[cell] > 1) row[cell] = -1;
    if (row[cell] >= 0) chaotic[cell] = chaos[row[cell]] === CHAOTIC ? 1 : 0;
  }
  return { value, row, rows, summed, chaotic, left, across, up };
}

// Which rows the slices leave; null where there are none.
function selected(table, state) {
  const slices = state.slices.filter(([, value]) => value !== null)
    .map(([name, value]) => [table.array(name), table.codeOf(name, value)]);
  if (!slices.length) return null;
  const found = new Uint8Array(table.rows);
  for (let r = 0; r < table.rows; r++) {
    let fits = 1;
    for (let k = 0; k < slices.length; k++) if (slices[k][0][r] !== slices[k][1]) { fits = 0; break; }
    found[r] = fits;
  }
  return found;
}
