//! Tables for papers, in LaTeX with the package booktabs.

use super::plain_table::Cells;

/// Returns a text in which nothing is a command.
pub(super) fn escaped(text: &str) -> String {
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

/// Returns a table.
///
/// # Arguments
///
/// * `about` — what it is a table of, which stands above it as a comment.
pub(super) fn table(about: &str, cells: &Cells) -> String {
    let side = |column: usize| if cells.right.contains(&column) { 'r' } else { 'l' };
    let columns: String = (0..cells.header.len()).map(side).collect();
    let row = |row: &[String]| {
        let cells: Vec<String> = row.iter().map(|cell| escaped(cell)).collect();
        format!("{} \\\\\n", cells.join(" & "))
    };
    let rows: String = cells.rows.iter().map(|cells| row(cells)).collect();
    format!(
        "% {}. In the preamble: \\usepackage{{booktabs}}.\n\\begin{{tabular}}{{{columns}}}\n\\toprule\n{}\\midrule\n{rows}\
         \\bottomrule\n\\end{{tabular}}\n",
        about.replace(['\n', '\r'], " "),
        row(&cells.header),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_its_columns_and_nothing_in_it_is_a_command() {
        let cells = Cells {
            header: vec!["method".to_owned(), "delay (s)".to_owned()],
            right: vec![1],
            rows: vec![vec!["my_method@50%".to_owned(), "<1".to_owned()]],
        };
        assert_eq!(
            table("Ranking", &cells),
            "% Ranking. In the preamble: \\usepackage{booktabs}.\n\\begin{tabular}{lr}\n\\toprule\nmethod & delay (s) \
             \\\\\n\\midrule\nmy\\_method@50\\% & $<$1 \\\\\n\\bottomrule\n\\end{tabular}\n"
        );
        assert_eq!(
            escaped("a\\b~^\n"),
            "a\\textbackslash{}b\\textasciitilde{}\\textasciicircum{} "
        );
    }
}
