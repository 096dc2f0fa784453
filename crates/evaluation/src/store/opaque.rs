//! JSON that is kept byte for byte, without being understood.

use serde::{Deserialize, Serialize};
use serde_json::value::{RawValue, to_raw_value};

/// JSON of a domain in the records of its tasks.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Opaque(Option<Box<RawValue>>);

impl Opaque {
    /// Returns plain data as JSON.
    pub fn of(data: &impl Serialize) -> Self {
        Self(Some(to_raw_value(data).expect("plain data")))
    }

    /// Returns the data, or its default if there is none.
    ///
    /// # Errors
    ///
    /// The parser's message when it is something else.
    pub fn read<'a, T: Deserialize<'a> + Default>(&'a self) -> Result<T, serde_json::Error> {
        self.0.as_ref().map_or_else(|| Ok(T::default()), |raw| serde_json::from_str(raw.get()))
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    fn text(&self) -> Option<&str> {
        self.0.as_ref().map(|raw| raw.get())
    }
}

impl PartialEq for Opaque {
    fn eq(&self, other: &Self) -> bool {
        self.text() == other.text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_and_written_again_has_the_same_bytes() {
        let text = r#"{"z":1.50,"a":[true,null]}"#;
        let opaque: Opaque = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&opaque).unwrap(), text);
        assert_eq!(opaque, opaque.clone());
        assert!(Opaque::default().is_empty() && !opaque.is_empty());
    }
}
