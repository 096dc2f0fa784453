//! Names of point MDPs: what people call an intersection, and the id that files and folders get.

use basics::hash::sha256;

/// Names of what lies beside the folders of point MDPs.
const RESERVED: [&str; 2] = ["INDEX.csv", "by-hash"];

/// Most characters in the id of a point MDP.
pub const MAX_ID: usize = 100;

/// Most characters of a name that its id starts with.
const KEPT: usize = 48;

/// Digits of the hash that tells ids of like names apart.
const DIGITS: usize = 8;

/// Letters that are written otherwise in an id.
const LETTERS: [(char, &str); 7] = [
    ('\u{e4}', "ae"),
    ('\u{f6}', "oe"),
    ('\u{fc}', "ue"),
    ('\u{c4}', "Ae"),
    ('\u{d6}', "Oe"),
    ('\u{dc}', "Ue"),
    ('\u{df}', "ss"),
];

/// Returns a name as people wrote it, with one blank between words.
pub fn title(what: &str, text: &str) -> Result<String, String> {
    sheet::name(text).ok_or_else(|| format!("{what} {text:?}: expected a name or a number"))
}

/// Returns the id of what is called so: the name itself where files can be called so, else its plain
/// letters and a hash, so that two names never have one id.
pub fn safe_id(title: &str) -> String {
    if check_id("", title).is_ok() {
        return title.to_owned();
    }
    let mut id = String::new();
    for letter in title.chars() {
        match LETTERS.iter().find(|(other, _)| *other == letter) {
            Some((_, plain)) => id.push_str(plain),
            None if letter.is_ascii_alphanumeric() || "_.".contains(letter) => id.push(letter),
            None if id.ends_with('-') => {}
            None => id.push('-'),
        }
    }
    let id: String = id.trim_start_matches(['-', '.']).chars().take(KEPT).collect();
    let hash = sha256(title.as_bytes());
    match id.trim_end_matches('-') {
        "" => format!("x-{}", &hash[..DIGITS]),
        id => format!("{id}-{}", &hash[..DIGITS]),
    }
}

/// Checks that an id is safe as a file name.
pub fn check_id(what: &str, id: &str) -> Result<(), String> {
    let safe = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if RESERVED.iter().any(|reserved| id.eq_ignore_ascii_case(reserved)) {
        return Err(format!(
            "{what} {id:?}: a part of every folder of networks is called so; choose another"
        ));
    }
    if id.is_empty() || id.len() > MAX_ID || !id.chars().all(safe) || id.starts_with('.') {
        return Err(format!(
            "{what} {id:?}: expected 1 to {MAX_ID} letters, digits, `-`, `_` or `.`, not starting \
             with `.`"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_files_can_have_is_its_own_id() {
        for id in ["n42", "Main-St_5", "a.b", "7"] {
            assert_eq!(safe_id(id), id);
        }
    }

    #[test]
    fn other_names_have_an_id_of_plain_letters() {
        let ids = [
            ("Main St / 5th Ave", "Main-St-5th-Ave-"),
            ("M\u{fc}hlstra\u{df}e", "Muehlstrasse-"),
            ("../a", "a-"),
            ("INDEX.csv", "INDEX.csv-"),
            (".hidden", "hidden-"),
            ("\u{4e2d}\u{5c71}\u{8def}", "x-"),
        ];
        for (name, start) in ids {
            let id = safe_id(name);
            assert!(id.starts_with(start) && id.len() == start.len() + DIGITS, "{name}: {id}");
            check_id("point", &id).unwrap();
        }
        let long = "x".repeat(300);
        check_id("point", &safe_id(&long)).unwrap();
    }

    #[test]
    fn names_that_differ_in_what_an_id_leaves_out_have_two_ids() {
        let names =
            ["a b", "a/b", "a  b?", "a-b", "\u{e4}", "ae", &"y".repeat(200), &"y".repeat(201)];
        let ids: std::collections::BTreeSet<String> = names.iter().map(|n| safe_id(n)).collect();
        assert_eq!(ids.len(), names.len());
    }

    #[test]
    fn a_name_of_blanks_is_refused() {
        assert!(title("point", " \t").unwrap_err().contains("expected a name"));
        assert_eq!(title("point", " a \n b ").unwrap(), "a b");
    }
}
