document.addEventListener("DOMContentLoaded", () => {
  const all = (node, what) => [...node.querySelectorAll(what)];
  const text = (row, column) => row.cells[column].textContent.trim();
  const make = (name, values) => Object.assign(document.createElement(name), values);
  // Columns of numbers by value, others by letter, and numbers within words by value; cells without a value come last
  // in both directions.
  const byLetter = new Intl.Collator("en", { numeric: true }).compare;
  // What is more than 99% comes after 99%, what is less than 1% before 1%.
  const beyond = (key) => 1e-6 * (key.startsWith("\u003e") - key.startsWith("\u003c"));
  const number = (key) => parseFloat(key.replace(/^[^-+\d]+(?=\d)/, "").replaceAll(",", ""));
  const value = (key) => number(key) + beyond(key);
  const compare = (numbers, down) => ([, a], [, b]) => {
    const lacks = (key) => (numbers ? !Number.isFinite(value(key)) : key === "" || key === "\u2013");
    if (lacks(a) || lacks(b)) return lacks(a) - lacks(b);
    return (numbers ? value(a) - value(b) : byLetter(a, b)) * (down ? -1 : 1);
  };
  for (const table of all(document, "table.sortable")) {
    const heads = all(table, "thead th");
    heads.forEach((head, column) => {
      head.tabIndex = 0;
      head.title = "sort";
      const sort = () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        const rows = [...table.tBodies[0].rows].map((row) => [row, text(row, column)]);
        const numbers = head.classList.contains("n");
        table.tBodies[0].append(...rows.sort(compare(numbers, down)).map(([row]) => row));
        heads.forEach((h) => h.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
      };
      head.addEventListener("click", sort);
      head.addEventListener("keydown", (e) => { if (e.key === "Enter") sort(); });
    });
  }
  for (const table of all(document, "table.filterable")) {
    const rows = [...table.tBodies[0].rows];
    const dots = new Map(all(document, "g[data-row]").map((dot) => [dot.dataset.row, dot]));
    const bar = make("p", { className: "controls" });
    const tests = [];
    const words = make("input", { type: "search", placeholder: "words in a row" });
    const found = make("output", {});
    const apply = () => {
      const shown = rows.filter((row) => {
        row.hidden = !tests.every((test) => test(row));
        dots.get(row.id)?.classList.toggle("off", row.hidden);
        return !row.hidden;
      });
      found.textContent = shown.length + " of " + rows.length + " rows";
    };
    const add = (name, control, test) => {
      const label = make("label", { textContent: name + " " });
      label.append(control);
      bar.append(label);
      control.addEventListener("input", apply);
      tests.push(test);
    };
    add("Show rows with", words, (row) => {
      const own = row.textContent.toLowerCase();
      return words.value.toLowerCase().split(" ").every((word) => own.includes(word));
    });
    all(table, "thead th").forEach((head, column) => {
      if (head.dataset.filter === undefined) return;
      const choice = make("select", {});
      const values = [...new Set(rows.map((row) => text(row, column)))].sort();
      choice.append(make("option", { value: "", textContent: "any" }));
      choice.append(...values.map((value) => make("option", { value, textContent: value })));
      add(head.dataset.filter, choice, (row) => choice.value === "" || text(row, column) === choice.value);
    });
    bar.append(found);
    table.parentElement.before(bar);
    apply();
  }
  document.addEventListener("click", (e) => {
    const dot = e.target.closest("g[data-row]");
    const row = dot ? document.getElementById(dot.dataset.row) : null;
    if (row) {
      row.hidden = false;
      dot.classList.remove("off");
      location.hash = row.id;
    }
  });
});
