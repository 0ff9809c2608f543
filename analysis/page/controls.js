// What the user chooses: native selects and sliders, so that a keyboard and a screen reader can work them.

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function select(place, label, options, chosen, changed) {
  const option = ([value, text, title = ""]) => element("option", { value, textContent: text, title });
  const list = element("select", {}, ...options.map(option));
  list.value = chosen;
  list.addEventListener("change", () => changed(list.value));
  place.append(element("label", {}, element("span", { textContent: label }), list));
  return list;
}

// A slider over the values of a parameter; its first place is all of them.
function slider(place, table, about, code, changed) {
  const { name, values } = about, said = element("output");
  const range = element("input", { type: "range", min: 0, max: values.length, step: 1, value: code + 1 });
  const tell = () => {
    const text = range.value === "0" ? `all ${values.length}` : table.text(name, values[range.value - 1]);
    said.textContent = text;
    range.setAttribute("aria-valuetext", text);
  };
  tell();
  range.addEventListener("input", () => { tell(); changed(Number(range.value) - 1); });
  place.append(element("label", { className: "slice", title: about.meaning },
    element("span", { textContent: name }), range, said));
}

// state: {x, y, of, xScale, yScale, ofScale, take, chaos, error, slices}; changed(): something in it did.
function controls(table, state, changed) {
  const put = (key) => (value) => { state[key] = value; controls(table, state, changed); changed(); };
  const numeric = [...table.about.keys()].filter((name) => table.isNumber(name));
  const listed = numeric.map((name) => [name, name, table.about.get(name).meaning]);
  const axes = document.getElementById("axes"), colours = document.getElementById("colours");
  const slices = document.getElementById("slices"), focused = document.activeElement?.closest("#choices label");
  const called = (label) => label.firstChild.textContent, name = focused && called(focused);
  for (const place of [axes, colours, slices]) place.replaceChildren();
  for (const [key, label] of [["x", "across"], ["y", "up"]]) {
    select(axes, label, listed, state[key], (value) => { state[`${key}Scale`] = "auto"; put(key)(value); });
    const scales = ["auto", ...(table.arrays.has(state[key]) ? possible(table, state[key]) : ["linear", "log"])];
    select(axes, `scale ${label}`, scales.map((one) => [one, one]), state[`${key}Scale`], put(`${key}Scale`));
  }
  select(colours, "colour", [...listed, ["rows", "number of rows"]], state.of, put("of"));
  select(colours, "scale of colour", ["auto", "linear", "log"].map((one) => [one, one]), state.ofScale, put("ofScale"));
  select(colours, "of many rows", ["lowest", "highest", "mean"].map((one) => [one, one]), state.take, put("take"));
  const chaos = [[CALM_FIRST, "if alone"], [LIKE_OTHERS, "like others"], [LEFT_OUT, "left out"]];
  select(colours, "chaotic rows", chaos, state.chaos, put("chaos"));
  const errors = [1e-4, 1e-3, 1e-2, 0.1, Infinity];
  const texts = errors.map((x) => [String(x), x === Infinity ? "never" : `${x * 100} %`]);
  select(colours, "dots above error", texts, String(state.error), (value) => put("error")(Number(value)));
  sliders(table, state, slices, changed);
  if (name) [...document.querySelectorAll("#choices label")].find((label) => called(label) === name)?.control.focus();
}

function sliders(table, state, place, changed) {
  const free = [...table.about.values()].filter((about) =>
    about.input && about.values && about.values.length > 1 && about.name !== state.x && about.name !== state.y);
  const before = new Map(state.slices);
  const held = ({ name }) => before.has(name) && before.get(name) !== null && table.codeOf(name, before.get(name)) >= 0;
  state.slices = free.map((about) => [about.name, held(about) ? before.get(about.name) : null]); // values outlast codes
  free.forEach((about, k) => {
    const value = state.slices[k][1], code = value === null ? -1 : table.codeOf(about.name, value);
    slider(place, table, about, code, (chosen) => {
      state.slices[k][1] = chosen < 0 ? null : about.values[chosen];
      changed();
    });
  });
  place.parentElement.hidden = !free.length;
}
