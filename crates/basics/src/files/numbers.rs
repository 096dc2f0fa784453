//! Numbers of files in JSON that somebody may have written by hand: what is finite there and too large for
//! whatever is computed of it would come out as infinite.

use serde_json::Value;

/// Largest number, positive or negative: sums of squares of as many as fit into memory are finite.
pub const LARGEST: f64 = 1e100;

/// Checks all numbers of a document.
///
/// # Errors
///
/// Where one is that is larger, and what was expected.
pub fn check(document: &Value) -> Result<(), String> {
    first_beyond(document).map_or(Ok(()), |(place, number)| Err(beyond(&place, number)))
}

/// Returns a number that cannot be computed with, and its place within the value.
fn first_beyond(value: &Value) -> Option<(String, f64)> {
    let within = |name: &dyn std::fmt::Display, value| {
        first_beyond(value).map(|(place, number)| (format!("/{name}{place}"), number))
    };
    match value {
        Value::Number(number) => {
            number.as_f64().filter(|n| !is_usable(*n)).map(|n| (String::new(), n))
        }
        Value::Array(values) => values.iter().enumerate().find_map(|(i, v)| within(&i, v)),
        Value::Object(fields) => fields.iter().find_map(|(name, v)| within(name, v)),
        Value::Null | Value::Bool(_) | Value::String(_) => None,
    }
}

/// Checks numbers that have names.
///
/// # Errors
///
/// The first that is larger, and what was expected.
pub fn check_all<'a>(
    numbers: impl IntoIterator<Item = (&'a String, &'a f64)>,
) -> Result<(), String> {
    match numbers.into_iter().find(|(_, number)| !is_usable(**number)) {
        None => Ok(()),
        Some((name, number)) => Err(beyond(name, *number)),
    }
}

/// Returns whether a number can be computed with, as [`check`] asks of all.
pub fn is_usable(number: f64) -> bool {
    number.abs() <= LARGEST
}

fn beyond(name: &str, number: f64) -> String {
    format!("{name} = {number:e}: expected a number from -1e100 to 1e100")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_number_that_is_too_large_is_named_with_its_place() {
        let usual =
            r#"{"a":[1,-2.5,{"seed":18446744073709551615,"b":null}],"c":"1e308","d":1e100}"#;
        assert_eq!(check(&serde_json::from_str(usual).unwrap()), Ok(()));
        let beyond = r#"{"a":[1,{"b":-1e308}],"c":1e200}"#;
        let expected = "/a/1/b = -1e308: expected a number from -1e100 to 1e100";
        assert_eq!(check(&serde_json::from_str(beyond).unwrap()).unwrap_err(), expected);
        assert!(serde_json::from_str::<Value>("1e999").is_err(), "no infinite numbers in JSON");
    }
}
