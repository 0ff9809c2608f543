// The rows of the table: packed columns, each unpacked when it is first needed.

const ARRAYS = { u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, i4: Int32Array, f4: Float32Array, f8: Float64Array };

async function unpack(text, kind) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new ARRAYS[kind](await new Response(stream).arrayBuffer());
}

class Table {
  // facts: what Python says of the rows; text(name): a column as it was packed, sooner or later.
  constructor(facts, text) {
    this.facts = facts;
    this.rows = facts.rows;
    this.packed = text;
    // What is not known of a number is null in JSON.
    const known = (column) => ({ ...column, values: column.values?.map((x) => x ?? NaN) });
    this.about = new Map(facts.columns.map((column) => [column.name, known(column)]));
    this.arrays = new Map();
    this.scaled = new Map();
    this.ranges = new Map();
    this.digits = new Map();
  }

  // A number of a column in few digits, but in as many as tell it from the column's other values.
  text(name, x) {
    const values = this.about.get(name).values;
    if (!this.digits.has(name)) this.digits.set(name, values ? apart(values) : 4);
    return shown(x, this.digits.get(name));
  }

  has(name) {
    return this.about.has(name);
  }

  // The column with the estimated error of what a column tells: its quantity's own, or ke_ratio's.
  errorOf(name) {
    const own = `${(name || "").replace(/_(linear|ratio)$/, "")}_error`;
    return this.has(own) ? own : "error";
  }

  async need(names) {
    const missing = names.filter((name) => name && this.has(name) && !this.arrays.has(name));
    await Promise.all(missing.map(async (name) => {
      const { kind } = this.about.get(name);
      const counted = kind === "count" ? Int32Array.from({ length: this.rows }, (_, row) => row) : null;
      this.arrays.set(name, counted || (await unpack(await this.packed(name), kind)));
    }));
  }

  // Codes where the column has `values`, else numbers.
  array(name) {
    return this.arrays.get(name);
  }

  value(name, row) {
    const about = this.about.get(name), held = this.arrays.get(name)[row];
    return about.values ? about.values[held] : held;
  }

  isNumber(name) {
    const about = this.about.get(name);
    return !about.values || typeof about.values[0] === "number";
  }

  // The code of a value; -1 where the column has no such value.
  codeOf(name, value) {
    return this.about.get(name).values.findIndex((x) => x === value || (x !== x && value !== value));
  }

  // The number of every row, whatever way the column is packed.
  numbers(name) {
    const about = this.about.get(name), held = this.arrays.get(name);
    if (!about.values) return held;
    if (!this.scaled.has(name)) this.scaled.set(name, Float64Array.from(held, (code) => about.values[code]));
    return this.scaled.get(name);
  }

  // Lowest, lowest above 0, highest of the known numbers of a column; nan where there are none.
  range(name) {
    if (!this.ranges.has(name)) {
      let low = Infinity, above = Infinity, high = -Infinity;
      const about = this.about.get(name); // an input's values are also those of rows that have failed
      for (const x of about.input && about.values ? about.values : this.numbers(name)) {
        if (x < low) low = x;
        if (x > 0 && x < above) above = x;
        if (x > high) high = x;
      }
      const known = low <= high;
      this.ranges.set(name, known ? { low, above: above === Infinity ? NaN : above, high }
        : { low: NaN, above: NaN, high: NaN });
    }
    return this.ranges.get(name);
  }
}

// How many digits it takes, or at least so many, to tell numbers apart.
function apart(values, least = 4) {
  const every = new Set(values).size;
  let digits = least;
  while (digits < 17 && new Set(values.map((x) => shown(x, digits))).size < every) digits++;
  return digits;
}

function counted(n, what = "row") {
  return `${n} ${what}${n === 1 ? "" : "s"}`;
}

// As many digits as the page has of a number.
function shown(value, digits = 6) {
  if (typeof value === "string") return value;
  if (Number.isNaN(value)) return "not known";
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return String(value);
  return String(Number(value.toPrecision(digits)));
}
