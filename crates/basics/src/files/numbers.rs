//! Numbers of files in JSON that somebody may have written by hand: what is finite there and too large for
//! whatever is computed of it would come out as infinite.

use std::borrow::Cow;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

/// Largest number, positive or negative: sums of squares of as many as fit into memory are finite.
pub const LARGEST: f64 = 1e100;

/// Checks all numbers of a document.
///
/// # Errors
///
/// Where the first is that is larger, and what was expected.
pub fn check(document: &Value) -> Result<(), String> {
    refuse(first_beyond(document).map_err(|e| e.to_string())?)
}

/// Checks all numbers of a document that is not in memory as values, which would take ten times its size.
///
/// # Errors
///
/// The parser's message, or that of [`check`].
pub fn check_text(document: impl AsRef<[u8]>) -> Result<(), String> {
    let mut parser = serde_json::Deserializer::from_slice(document.as_ref());
    let found = first_beyond(&mut parser).map_err(|e| e.to_string())?;
    parser.end().map_err(|e| e.to_string())?;
    refuse(found)
}

/// Returns the first number that cannot be computed with, and where it is.
fn first_beyond<'de, D: Deserializer<'de>>(document: D) -> Result<Option<(String, f64)>, D::Error> {
    let (mut place, mut found) = (String::new(), None);
    First { place: &mut place, found: &mut found }.deserialize(document)?;
    Ok(found)
}

fn refuse(found: Option<(String, f64)>) -> Result<(), String> {
    found.map_or(Ok(()), |(place, number)| Err(beyond(&place, number)))
}

/// Finds the first number that cannot be computed with.
struct First<'a> {
    /// Where the parser is.
    place: &'a mut String,
    found: &'a mut Option<(String, f64)>,
}

impl First<'_> {
    /// Returns what looks at a value within this one.
    fn within(&mut self, name: &dyn fmt::Display) -> First<'_> {
        self.place.push_str(&format!("/{name}"));
        First { place: self.place, found: self.found }
    }
}

impl<'de> DeserializeSeed<'de> for First<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for First<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a document")
    }

    fn visit_f64<E>(self, number: f64) -> Result<(), E> {
        if self.found.is_none() && !is_usable(number) {
            *self.found = Some((self.place.clone(), number));
        }
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut values: A) -> Result<(), A::Error> {
        let length = self.place.len();
        for i in 0usize.. {
            let next = values.next_element_seed(self.within(&i))?;
            self.place.truncate(length);
            if next.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut fields: A) -> Result<(), A::Error> {
        let length = self.place.len();
        while let Some(name) = fields.next_key::<Cow<'_, str>>()? {
            fields.next_value_seed(self.within(&name))?;
            self.place.truncate(length);
        }
        Ok(())
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
        assert_eq!(check_text(usual), Ok(()));
        let beyond = r#"{"a":[1,{"b":-1e308}],"c":1e200}"#;
        let expected = "/a/1/b = -1e308: expected a number from -1e100 to 1e100";
        assert_eq!(check(&serde_json::from_str(beyond).unwrap()).unwrap_err(), expected);
        assert_eq!(check_text(beyond).unwrap_err(), expected);
        assert!(check_text("{\"a\":1}}").unwrap_err().starts_with("trailing characters"));
        assert!(serde_json::from_str::<Value>("1e999").is_err(), "no infinite numbers in JSON");
    }
}
