//! Texts in LaTeX.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_text_is_a_command() {
        assert_eq!(
            escaped("a\\b~^\n"),
            "a\\textbackslash{}b\\textasciitilde{}\\textasciicircum{} "
        );
    }
}
