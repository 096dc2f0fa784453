//! Numbers of files in JSON that somebody may have written by hand: what is finite there and too large for
//! whatever is computed of it would come out as infinite.

use serde_json::Value;

/// Largest number, positive or negative: sums of squares of as many as fit into memory are finite.
pub const LARGEST: f64 = 1e100;

/// Checks all numbers of a document.
///
/// # Errors
///
/// Where the first is that is larger, and what was expected.
pub fn check(document: &Value) -> Result<(), String> {
    let mut place = String::new();
    match first_beyond(document, &mut place) {
        None => Ok(()),
        Some(number) => Err(beyond(&place, number)),
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

fn is_usable(number: f64) -> bool {
    number.abs() <= LARGEST
}

fn beyond(name: &str, number: f64) -> String {
    format!("{name} = {number:e}: expected a number from -1e100 to 1e100")
}

/// Returns the first number that cannot be computed with; `place` is where it is then.
fn first_beyond(value: &Value, place: &mut String) -> Option<f64> {
    let length = place.len();
    let mut within = |name: &dyn std::fmt::Display, value: &Value| {
        if matches!(value, Value::Null | Value::Bool(_) | Value::String(_)) {
            return None;
        }
        place.push_str(&format!("/{name}"));
        let found = first_beyond(value, place);
        if found.is_none() {
            place.truncate(length);
        }
        found
    };
    match value {
        Value::Number(number) => number.as_f64().filter(|number| !is_usable(*number)),
        Value::Array(values) => values.iter().enumerate().find_map(|(i, value)| within(&i, value)),
        Value::Object(fields) => fields.iter().find_map(|(name, value)| within(name, value)),
        _ => None,
    }
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
        assert_eq!(
            check(&serde_json::from_str(beyond).unwrap()).unwrap_err(),
            "/a/1/b = -1e308: expected a number from -1e100 to 1e100"
        );
        assert!(serde_json::from_str::<Value>("1e999").is_err(), "no infinite numbers in JSON");
    }
}
