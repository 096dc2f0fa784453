//! Evaluation seeds that are given in a file.

use std::collections::HashMap;
use std::path::Path;

use crate::cli::refused::Refused;
use crate::files::{self, limits};
use crate::seed::evaluation_of;
use crate::store::most::MOST_EVALUATION_SEEDS;

/// Reads evaluation seeds: a whole number per line; what follows a `#` is a comment.
pub(super) fn read(path: &Path) -> anyhow::Result<Vec<u64>> {
    let text = files::read_text(path, limits::DOCUMENT)?;
    let found = parse(&text).map_err(|reason| Refused(format!("{}: {reason}", path.display())));
    Ok(found?)
}

fn parse(text: &str) -> Result<Vec<u64>, String> {
    let (mut seeds, mut lines) = (Vec::new(), HashMap::new());
    for (line, text) in (1..).zip(text.lines()) {
        let number = text.split('#').next().unwrap_or_default().trim();
        if number.is_empty() {
            continue;
        }
        let seed = number.parse().ok().and_then(evaluation_of).ok_or_else(|| {
            format!("line {line}: {number:?} is no seed; give one whole number from 0 to 2147483647 per line")
        })?;
        if let Some(before) = lines.insert(seed, line) {
            return Err(format!("line {line}: the seed {number} is in line {before} already"));
        }
        seeds.push(seed);
    }
    match seeds.len() {
        0 => Err("it has no seed; give one whole number per line".to_owned()),
        n if n > MOST_EVALUATION_SEEDS as usize => {
            Err(format!("it has {n} seeds; a run has at most {MOST_EVALUATION_SEEDS}"))
        }
        _ => Ok(seeds),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_a_seed_per_line() {
        let first = evaluation_of(1).unwrap();
        assert_eq!(
            parse("# of the paper\n1\n\n 1889785958 # as in a manifest\n"),
            Ok(vec![first, 1_889_785_958])
        );
    }

    #[test]
    fn what_is_no_list_of_seeds_is_said_with_its_line() {
        assert!(parse("1\n2,3\n").unwrap_err().starts_with("line 2: \"2,3\" is no seed"));
        assert!(parse("-1").unwrap_err().starts_with("line 1: \"-1\" is no seed"));
        assert!(parse("2147483648").is_err());
        assert_eq!(parse("7\n\n7\n").unwrap_err(), "line 3: the seed 7 is in line 1 already");
        // The same episode in its two ways of writing.
        assert!(parse("7\n1073741831\n").unwrap_err().contains("is in line 1 already"));
        assert!(parse("# nothing\n").unwrap_err().starts_with("it has no seed"));
    }
}
