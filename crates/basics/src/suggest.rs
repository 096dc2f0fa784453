//! What a mistyped name may have meant.

/// Similarity from which a name may have been meant, as clap takes it.
const SIMILAR: f64 = 0.7;

const MOST: usize = 3;

/// Returns the names that a word may have meant, the likeliest first; none if it is like none.
pub fn similar<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    best(names.into_iter().map(|name| (likeness(word, name), name)))
}

/// Returns the dotted names that a setting may have meant, the likeliest first. Of `demand.horizon` both
/// parts count; `horizon` alone is compared with the last parts.
pub fn similar_settings<'a>(key: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let last = |name: &'a str| name.rsplit_once('.').unwrap_or(("", name));
    best(names.into_iter().map(|name| {
        let of_last = |word: &str| likeness(word, last(name).1);
        let likeness = match key.rsplit_once('.') {
            // `steps` of whatever table may mean `total_steps`.
            Some((table, word)) if last(name).1.strip_prefix("total_") == Some(word) => {
                if table == last(name).0 { 1.0 } else { 0.9 }
            }
            Some((table, word)) => {
                (0.3 * likeness(table, last(name).0) + 0.7 * of_last(word)).max(likeness(key, name))
            }
            None => of_last(key),
        };
        (likeness, name)
    }))
}

fn likeness(word: &str, name: &str) -> f64 {
    let plain = |text: &str| text.trim().to_lowercase().replace([' ', '_'], "-");
    strsim::jaro(&plain(word), &plain(name))
}

fn best<'a>(names: impl Iterator<Item = (f64, &'a str)>) -> Vec<&'a str> {
    let mut names: Vec<_> = names.filter(|(likeness, _)| *likeness > SIMILAR).collect();
    names.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(b.1)));
    let top = names.first().map_or(0.0, |(likeness, _)| *likeness);
    // Beside a name that is nearly it, others are noise.
    names.retain(|(likeness, _)| 1.0 - likeness <= 2.0 * (1.0 - top) + f64::EPSILON);
    names.into_iter().map(|(_, name)| name).take(MOST).collect()
}

/// Returns `; did you mean ...?` to be put behind a message, or nothing.
pub fn did_you_mean<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    match similar(word, names).as_slice() {
        [] => String::new(),
        names => format!("; did you mean {}?", names.join(" or ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 4] = ["max-pressure", "max-pressure-resco", "actuated", "fixed-time"];

    #[test]
    fn a_mistyped_name_is_recognised() {
        for (word, expected) in [
            ("actuatd", "actuated"),
            ("Fixed Time", "fixed-time"),
            ("fixd_time", "fixed-time"),
            ("maxpressure", "max-pressure"),
        ] {
            assert_eq!(similar(word, NAMES)[0], expected, "{word}");
        }
    }
}
