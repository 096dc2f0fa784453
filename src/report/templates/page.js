document.addEventListener("DOMContentLoaded", () => {
  const all = (node, what) => [...node.querySelectorAll(what)];
  const text = (row, column) => row.cells[column].textContent.trim();
  const make = (name, values) => Object.assign(document.createElement(name), values);
  // Numbers by value, other texts by letter, cells without a value last in both directions.
  const compare = (down) => ([a, ka], [b, kb]) => {
    const [x, y] = [parseFloat(ka), parseFloat(kb)];
    const [noX, noY] = [!Number.isFinite(x), !Number.isFinite(y)];
    if (noX !== noY) return noX ? 1 : -1;
    return (noX ? ka.localeCompare(kb) : x - y) * (down ? -1 : 1);
  };
  for (const table of all(document, "table.sortable")) {
    const heads = all(table, "thead th");
    heads.forEach((head, column) => {
      head.tabIndex = 0;
      head.title = "sort";
      const sort = () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        const rows = [...table.tBodies[0].rows].map((row) => [row, text(row, column)]);
        table.tBodies[0].append(...rows.sort(compare(down)).map(([row]) => row));
        heads.forEach((h) => h.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
      };
      head.addEventListener("click", sort);
      head.addEventListener("keydown", (e) => { if (e.key === "Enter") sort(); });
    });
  }
  for (const table of all(document, "table.filterable")) {
    const rows = [...table.tBodies[0].rows];
    const bar = make("p", { className: "controls" });
    const tests = [];
    const words = make("input", { type: "search", placeholder: "words in a row" });
    const found = make("output", {});
    const apply = () => {
      const shown = rows.filter((row) => {
        row.hidden = !tests.every((test) => test(row));
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
      location.hash = row.id;
    }
  });
});
