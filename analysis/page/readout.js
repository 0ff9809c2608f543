// Words for what the picture shows: the row under the pointer, the rows picked, and files to take away.

const PICKED_MOST = 200;

function rowList(table, row) {
  const list = element("dl");
  for (const [name, about] of table.about) {
    if (!table.arrays.has(name)) continue;
    const held = table.value(name, row), value = shown(held, table.facts.digits > 7 ? 10 : 7);
    list.append(element("dt", { textContent: name, title: about.meaning }),
      element("dd", { textContent: about.unit.length > 1 && !Number.isNaN(held) ? `${value} ${about.unit}` : value }));
  }
  return list;
}

// What every column is: for those who cannot hover.
function meanings(table) {
  const list = document.getElementById("meanings");
  list.replaceChildren();
  for (const [name, about] of table.about) {
    const unit = about.unit.length > 1 ? `, in ${about.unit}` : "";
    list.append(element("dt", { textContent: name }), element("dd", { textContent: about.meaning + unit }));
  }
}

// Of a cell without a number: of its rows so many are chaotic and left out.
function nothing(rows, left) {
  if (!left) return rows ? `${counted(rows)}, no number` : "no row done";
  return left === rows ? `${counted(rows)}, chaotic: left out`
    : `${counted(rows)}: ${left} chaotic, left out; ${rows - left} without a number`;
}

function told(table, state, cells, cell) {
  const row = cells.row[cell], x = cells.value[cell];
  if (row < 0 && Number.isNaN(x)) return nothing(cells.rows[cell], cells.left[cell]);
  const at = row < 0 ? "" : [...table.about.values()].filter((about) => about.input)
    .map((about) => `${about.name} ${table.text(about.name, table.value(about.name, row))}`).join(", ");
  const of = state.of === "rows" ? "rows" : row < 0 ? `mean ${state.of} of ${counted(cells.summed[cell])}` : state.of;
  return `${of} ${shown(x, 4)}${at ? ` at ${at}` : ""}${cells.chaotic[cell] ? ", chaotic" : ""}`;
}

class Readout {
  constructor(table, picked) {
    this.table = table;
    this.rows = []; // picked
    this.picked = picked;
    this.said = document.getElementById("said");
    this.invitation = this.said.textContent;
    this.row = document.getElementById("row");
  }

  // Where the user points to nothing that the picture shows.
  clear() {
    this.last = null;
    this.said.textContent = this.invitation;
    this.row.replaceChildren();
  }

  async show(state, cells, cell) {
    this.said.textContent = told(this.table, state, cells, cell);
    const row = cells.row[cell], table = this.table;
    if (row === this.last) return;
    this.last = row;
    if (row < 0) return this.row.replaceChildren();
    await table.need([...table.about.keys()]);
    if (this.last === row && this.table === table) this.row.replaceChildren(rowList(table, row));
  }

  pick(row) {
    if (row < 0) return;
    if (!this.rows.includes(row) && this.rows.length < PICKED_MOST) {
      this.rows.push(row);
      this.list();
    }
    this.picked(row);
  }

  async list() {
    const table = this.table;
    await table.need([...table.about.keys()]);
    if (table !== this.table) return; // it has grown meanwhile, and was listed anew
    const names = [...table.about.keys()], head = element("tr", {}, element("td"));
    for (const name of names) head.append(element("th", { scope: "col", textContent: name, title: table.about.get(name).meaning }));
    const lines = this.rows.map((row) => {
      const away = element("button", { type: "button", textContent: "remove" });
      away.setAttribute("aria-label", `remove task ${table.value("task", row)}`);
      away.addEventListener("click", () => { this.rows = this.rows.filter((one) => one !== row); this.list(); });
      const line = element("tr", {}, element("td", {}, away));
      for (const name of names) line.append(element("td", { textContent: shown(table.value(name, row), 6) }));
      return line;
    });
    document.getElementById("picked").hidden = !lines.length;
    document.getElementById("picked-rows").replaceChildren(element("thead", {}, head), element("tbody", {}, ...lines));
  }
}

// Flags as an exported table has them, and whether a row was checked.
const FLAGS = { yes: ["True", "True"], no: ["False", "True"], "not checked": ["", "False"] };

// Exact where the page has every digit, else the seven that it has; empty: not known.
function csv(table, rows) {
  const names = [...table.about.keys()], exact = table.facts.digits > 7;
  const cell = (name, row) => {
    const value = table.value(name, row);
    if (name === "chaotic") return FLAGS[value].join(",");
    if (typeof value === "string") return /[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value;
    if (Number.isNaN(value)) return "";
    return exact || table.about.get(name).kind !== "f4" ? String(value) : String(Number(value.toPrecision(7)));
  };
  const heads = names.map((name) => (name === "chaotic" ? "chaotic,checked" : name));
  return [heads.join(","), ...rows.map((row) => names.map((name) => cell(name, row)).join(","))].join("\n") + "\n";
}

// The rows that the slices leave and that lie in view.
function inView(table, state, across, up, [x0, x1, y0, y1]) {
  const wanted = selected(table, state), x = table.numbers(across.name), y = table.numbers(up.name), found = [];
  const inside = (axis, value, low, high) => {
    const s = axis.forward(value);
    return !Number.isNaN(value) && s >= low && s <= high;
  };
  for (let row = 0; row < table.rows; row++) {
    if (wanted && !wanted[row]) continue;
    if (inside(across, x[row], x0, x1) && inside(up, y[row], y0, y1)) found.push(row);
  }
  return found;
}

function save(blob, name) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
