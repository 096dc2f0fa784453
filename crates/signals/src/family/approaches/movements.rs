//! The letters of the turns of an approach, in both cases.
//!
//! `l` is a left and `r` a right turn, `s` and `t` are through (straight on), `u` is a U-turn, which nobody
//! builds. In the table of Salt Lake City, and in those made like it, `t` is a U-turn: a row that has both
//! `s` and `t` shows that, as no approach goes straight on twice, and then it holds for the whole table.

use super::approach::Approach;

/// What separates letters for some people.
const BETWEEN: [char; 5] = [' ', ',', ';', '/', '+'];

/// Letters that are understood, in lower case.
const KNOWN: [char; 5] = ['l', 's', 't', 'r', 'u'];

/// Returns the letters in lower case, each once, without what separates them.
pub(super) fn letters(text: &str) -> Result<String, String> {
    let mut letters = String::new();
    for c in text.chars().filter(|c| !BETWEEN.contains(c)) {
        let letter = c.to_ascii_lowercase();
        if !KNOWN.contains(&letter) {
            return Err(format!(
                "movements has the letter {c:?}: expected some of l (left), s or t (through), r (right), \
                 u (U-turn)"
            ));
        }
        if !letters.contains(letter) {
            letters.push(letter);
        }
    }
    Ok(letters)
}

/// Gives `t` its meaning: it becomes `s`, through, unless a row of the table has both, so that it is a U-turn.
pub(super) fn settle(approaches: &mut [Approach]) {
    if approaches.iter().any(|a| a.movements.contains('s') && a.movements.contains('t')) {
        return;
    }
    for approach in approaches {
        approach.movements = approach.movements.replace('t', "s");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn case_and_what_stands_between_letters_do_not_matter() {
        assert_eq!(letters("L, T, R").unwrap(), "ltr");
        assert_eq!(letters("sslr").unwrap(), "slr");
        assert_eq!(letters("").unwrap(), "");
        assert_eq!(
            letters("lxr").unwrap_err(),
            "movements has the letter 'x': expected some of l (left), s or t (through), r (right), u \
             (U-turn)"
        );
    }
}
