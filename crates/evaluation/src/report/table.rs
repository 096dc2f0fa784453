//! One table in all its forms: with all digits as CSV and as lines of JSON, and as people read it on a terminal, in
//! LaTeX and on a page.

use std::fmt::Write;

use comfy_table::{CellAlignment, LineStyle, Table as Plain, TableStyle};
use serde_json::{Map, Value};

use super::csv;

/// What stands where nothing is known.
const UNKNOWN: &str = "-";

/// What a cell holds.
#[derive(Debug, Clone, PartialEq, Default)]
enum Datum {
    #[default]
    Unknown,
    Text(String),
    Flag(bool),
    Count(usize),
    Number(f64),
}

/// A cell: what it holds, and what people read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cell {
    datum: Datum,
    shown: String,
    /// What stands below it, such as an interval.
    below: Option<String>,
}

impl Cell {
    /// Returns a cell with a text; an empty one is not known.
    pub fn text(text: impl Into<String>) -> Self {
        let text = text.into();
        match text.is_empty() {
            true => Self::unknown(),
            false => Self { datum: Datum::Text(text.clone()), shown: text, below: None },
        }
    }

    /// Returns the cell of what is so or not.
    pub fn flag(is: Option<bool>) -> Self {
        let cell = |is: bool| Self { datum: Datum::Flag(is), shown: is.to_string(), below: None };
        is.map_or_else(Self::unknown, cell)
    }

    /// Returns a cell with a whole number.
    pub fn count(n: usize) -> Self {
        Self { datum: Datum::Count(n), shown: n.to_string(), below: None }
    }

    /// Returns a cell with a number, and how people read it.
    pub fn number(value: impl Into<Option<f64>>, shown: impl FnOnce(f64) -> String) -> Self {
        match value.into() {
            Some(value) => Self { datum: Datum::Number(value), shown: shown(value), below: None },
            None => Self::unknown(),
        }
    }

    /// Returns a cell with a number that nobody reads but programs.
    pub fn exact(value: impl Into<Option<f64>>) -> Self {
        Self::number(value, |value| value.to_string())
    }

    /// Returns the cell of a text that may be a number.
    pub fn parsed(text: &str) -> Self {
        match (text.parse(), text.parse()) {
            (Ok(n), _) => Self::count(n),
            (_, Ok(value)) => Self::exact(Some(value)),
            _ => Self::text(text),
        }
    }

    /// Returns the cell of what is not known.
    pub fn unknown() -> Self {
        Self { shown: UNKNOWN.to_owned(), ..Self::default() }
    }

    /// Returns the same with something below it.
    pub fn above(self, below: Option<String>) -> Self {
        Self { below, ..self }
    }

    fn csv(&self) -> String {
        match &self.datum {
            Datum::Unknown => String::new(),
            Datum::Text(text) => text.clone(),
            Datum::Flag(is) => is.to_string(),
            Datum::Count(n) => n.to_string(),
            Datum::Number(value) => value.to_string(),
        }
    }

    fn json(&self) -> Value {
        match &self.datum {
            Datum::Unknown => Value::Null,
            Datum::Text(text) => text.clone().into(),
            Datum::Flag(is) => (*is).into(),
            Datum::Count(n) => (*n).into(),
            Datum::Number(value) => (*value).into(),
        }
    }

    fn latex(&self) -> String {
        let shown = latex_escaped(&bracketed(&self.shown));
        match &self.below {
            Some(below) => format!("{shown} {}", latex_escaped(&bracketed(below))),
            None => shown,
        }
    }

    fn line(&self) -> String {
        match &self.below {
            Some(below) => format!("{} ({below})", self.shown),
            None => self.shown.clone(),
        }
    }
}

/// Makes a column's cell of a row.
type ToCell<'a, R> = Box<dyn Fn(&R) -> Cell + 'a>;

/// The columns of a table whose rows are of one kind.
pub struct Columns<'a, R> {
    heads: Vec<Head>,
    cells: Vec<ToCell<'a, R>>,
}

impl<'a, R> Columns<'a, R> {
    /// Returns no columns yet.
    #[expect(clippy::new_without_default, reason = "no columns are no table")]
    pub fn new() -> Self {
        Self { heads: Vec::new(), cells: Vec::new() }
    }

    fn with(
        mut self,
        (name, heading): (String, String),
        right: bool,
        cell: impl Fn(&R) -> Cell + 'a,
    ) -> Self {
        self.heads.push(Head { name, heading, right });
        self.cells.push(Box::new(cell));
        self
    }

    /// Adds a column of numbers with its name in files and its heading for people.
    pub fn column(
        self,
        name: impl Into<String>,
        heading: impl Into<String>,
        cell: impl Fn(&R) -> Cell + 'a,
    ) -> Self {
        self.with((name.into(), heading.into()), true, cell)
    }

    /// Adds a column of texts; where name or heading is empty, files or people do not have it.
    pub fn text(self, name: &str, heading: &str, text: impl Fn(&R) -> String + 'a) -> Self {
        self.with((name.into(), heading.into()), false, move |row| Cell::text(text(row)))
    }

    /// Adds a column of files alone.
    pub fn file(self, name: impl Into<String>, cell: impl Fn(&R) -> Cell + 'a) -> Self {
        self.column(name, "", cell)
    }

    /// Adds a column for people alone.
    pub fn shown(self, heading: impl Into<String>, cell: impl Fn(&R) -> Cell + 'a) -> Self {
        self.column("", heading, cell)
    }

    /// Returns the table of some rows.
    pub fn table(self, rows: impl IntoIterator<Item = R>) -> Table {
        let Self { heads, cells } = self;
        let row = |row: R| cells.iter().map(|cell| cell(&row)).collect();
        Table { heads, rows: rows.into_iter().map(row).collect() }
    }
}

/// A column of a table, and its cells.
#[derive(Debug, Clone, PartialEq)]
struct Head {
    name: String,
    heading: String,
    right: bool,
}

/// A table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    heads: Vec<Head>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    fn seen(&self) -> impl Iterator<Item = (usize, &Head)> {
        self.heads.iter().enumerate().filter(|(_, head)| !head.heading.is_empty())
    }

    fn named(&self) -> impl Iterator<Item = (usize, &Head)> {
        self.heads.iter().enumerate().filter(|(_, head)| !head.name.is_empty())
    }

    /// Returns the table as CSV.
    pub fn csv(&self) -> String {
        let header: Vec<&str> = self.named().map(|(_, head)| head.name.as_str()).collect();
        let row = |row: &Vec<Cell>| self.named().map(|(i, _)| row[i].csv()).collect();
        csv::table(&header, self.rows.iter().map(row))
    }

    /// Returns a row per line of JSON; `null` is what is not known.
    pub fn json(&self) -> Vec<Map<String, Value>> {
        let row = |row: &Vec<Cell>| {
            self.named().map(|(i, head)| (head.name.clone(), row[i].json())).collect()
        };
        self.rows.iter().map(row).collect()
    }

    /// Returns the table for terminals: plain text with a rule below its heading.
    pub fn plain(&self) -> String {
        let mut table = Plain::new();
        let rule = LineStyle::none().fill('-').junction('-');
        let headings: Vec<&str> = self.seen().map(|(_, head)| head.heading.as_str()).collect();
        table.load_style(TableStyle::new().header_separator(rule)).set_header(&headings);
        for (i, (_, head)) in self.seen().enumerate() {
            if let Some(column) = table.column_mut(i).filter(|_| head.right) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        for row in &self.rows {
            table.add_row(self.seen().map(|(i, _)| row[i].line()));
        }
        table.trim_fmt()
    }

    /// Returns the table in LaTeX for the package booktabs.
    ///
    /// # Arguments
    ///
    /// * `about` — what it is a table of, which stands above it as a comment.
    /// * `best` — whether the first row is the best and bold.
    pub fn latex(&self, about: &str, best: bool) -> String {
        let columns: String =
            self.seen().map(|(_, head)| if head.right { 'r' } else { 'l' }).collect();
        let line = |cells: Vec<String>| format!("{} \\\\\n", cells.join(" & "));
        let heading = line(self.seen().map(|(_, head)| latex_escaped(&head.heading)).collect());
        let row = |(number, row): (usize, &Vec<Cell>)| {
            let bold = |cell: String| match best && number == 0 {
                true => format!("\\textbf{{{cell}}}"),
                false => cell,
            };
            line(self.seen().map(|(i, _)| bold(row[i].latex())).collect())
        };
        let rows: String = self.rows.iter().enumerate().map(row).collect();
        format!(
            "% {}. In the preamble: \\usepackage{{booktabs}}.\n\\begin{{tabular}}{{{columns}}}\n\\toprule\n{heading}\\midrule\n\
             {rows}\\bottomrule\n\\end{{tabular}}\n",
            about.replace(['\n', '\r'], " "),
        )
    }

    /// Returns the table for a page.
    pub fn html(&self, caption: &str) -> String {
        let escape = |text: &str| quick_xml::escape::escape(text).into_owned();
        let side = |right: bool| if right { " class=\"n\"" } else { "" };
        let mut html = format!("<table>\n<caption>{}</caption>\n<thead><tr>", escape(caption));
        for (_, head) in self.seen() {
            let (side, heading) = (side(head.right), escape(&head.heading));
            // Writing to a string cannot fail.
            let _ = write!(html, "<th scope=\"col\"{side}>{heading}</th>");
        }
        html.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            html.push_str("<tr>");
            for (nth, (i, head)) in self.seen().enumerate() {
                let cell = &row[i];
                let mut text = escape(&cell.shown);
                if let Some(below) = &cell.below {
                    let _ = write!(text, "<span class=\"unit\">{}</span>", escape(below));
                }
                let _ = match nth {
                    0 => write!(html, "<th scope=\"row\"{}>{text}</th>", side(head.right)),
                    _ => write!(html, "<td{}>{text}</td>", side(head.right)),
                };
            }
            html.push_str("</tr>\n");
        }
        html + "</tbody>\n</table>\n"
    }
}

/// Returns an interval as papers write it, and any other text as it is.
fn bracketed(text: &str) -> String {
    let is_number = |end: &&str| end.trim_end_matches('%').parse::<f64>().is_ok();
    let ends = text.split_once(" to ").filter(|(low, high)| is_number(low) && is_number(high));
    ends.map_or_else(|| text.to_owned(), |(low, high)| format!("[{low}, {high}]"))
}

/// Returns a text in which nothing is a command of LaTeX.
fn latex_escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', c]),
            '\\' => escaped.push_str("\\textbackslash{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '^' => escaped.push_str("\\textasciicircum{}"),
            '<' => escaped.push_str("$<$"),
            '>' => escaped.push_str("$>$"),
            '\u{2265}' => escaped.push_str("$\\geq$"),
            '\u{2264}' => escaped.push_str("$\\leq$"),
            '\u{2212}' => escaped.push_str("$-$"),
            '\u{d7}' => escaped.push_str("$\\times$"),
            '\u{b1}' => escaped.push_str("$\\pm$"),
            '\u{2013}' => escaped.push_str("--"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_same_in_every_form() {
        let rows = [("a_b", Some(0.5), 3), ("<c>", None, 0)];
        let table = Columns::<(&str, Option<f64>, usize)>::new()
            .text("method", "method", |r| r.0.to_owned())
            .column("score", "score", |r| {
                Cell::number(r.1, |v| format!("{v:.2}")).above(r.1.map(|_| "0.4 to 0.6".into()))
            })
            .file("failed", |r| Cell::count(r.2))
            .table(rows);
        assert_eq!(table.csv(), "method,score,failed\na_b,0.5,3\n<c>,,0\n");
        assert_eq!(table.json()[1]["score"], Value::Null);
        assert_eq!(table.plain().lines().nth(2).map(str::trim), Some("a_b      0.50 (0.4 to 0.6)"));
        let best = "method & score \\\\\n\\midrule\n\\textbf{a\\_b} & \\textbf{0.50 [0.4, 0.6]}";
        assert!(table.latex("T", true).contains(best));
        let row = "<tr><th scope=\"row\">&lt;c&gt;</th><td class=\"n\">-</td></tr>";
        assert!(table.html("T").contains(row));
    }

    #[test]
    fn nothing_in_a_text_is_a_command() {
        assert_eq!(
            latex_escaped("a\\b~^\n"),
            "a\\textbackslash{}b\\textasciitilde{}\\textasciicircum{} "
        );
    }
}
