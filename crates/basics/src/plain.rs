//! What anybody may have written stays text where it is shown: nothing in a name moves the cursor, rings, hides or
//! turns around what stands beside it, and no cell of a table is computed by the program that opens it.
//! Names of streets, ids, titles, reasons, logs and names of files come from anybody. Whatever acts on a terminal
//! is written as `\u001b`, which is what it is in JSON as well, so that lines of JSON stay what they are.

use std::borrow::Cow;
use std::fmt::Write;

/// Returns a text in which nothing acts on a terminal but line ends and tabs.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len() + 16);
    for letter in text.chars() {
        if !acts(letter) {
            safe.push(letter);
            continue;
        }
        for unit in letter.encode_utf16(&mut [0; 2]) {
            write!(safe, "\\u{unit:04x}").expect("writing to a string cannot fail");
        }
    }
    Cow::Owned(safe)
}

/// Returns a text as a cell of a table, which no spreadsheet takes for a formula: one that begins like a formula gets an
/// apostrophe before it, unless it is a number. `sheet` reads it without the apostrophe.
/// Source: OWASP, "CSV Injection".
pub fn cell(text: &str) -> Cow<'_, str> {
    if text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err() {
        return Cow::Owned(format!("'{}", plain(text)));
    }
    plain(text)
}

/// Whether a character is more than a sign on the screen: control characters, those that order or embed what is
/// written from right to left, line and paragraph separators, and tags, which nobody sees.
fn acts(letter: char) -> bool {
    match letter {
        '\n' | '\t' => false,
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{e0000}'..='\u{e007f}' => true,
        other => other.is_control(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_shown_and_every_script_stays() {
        let text = "Łódź, Straße 5, 東京\tشارع\n👩‍🚒";
        assert!(matches!(plain(text), Cow::Borrowed(same) if same == text));
        assert_eq!(
            plain("\u{1b}[2J\u{7}\rx\u{8}\u{7f}\u{9b}31m\u{202e}txt\u{2066}\u{e0041}\0"),
            "\\u001b[2J\\u0007\\u000dx\\u0008\\u007f\\u009b31m\\u202etxt\\u2066\\udb40\\udc41\\u0000"
        );
    }

    #[test]
    fn a_cell_is_no_formula_and_numbers_stay() {
        assert_eq!(cell("=HYPERLINK(1)"), "'=HYPERLINK(1)");
        assert_eq!(cell("-cmd"), "'-cmd");
        assert_eq!(cell("a\u{202e}b"), "a\\u202eb");
        for same in ["-1.5", "+3", "-inf", "a=b", "", "5-6"] {
            assert!(matches!(cell(same), Cow::Borrowed(text) if text == same), "{same}");
        }
    }
}
