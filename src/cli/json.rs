//! Lines of `--json`.

use serde_json::{Map, Value};

/// Returns a method as `--json` prints it.
pub(super) fn method_line(mut row: Map<String, Value>) -> Value {
    row.insert("event".to_owned(), "method".into());
    Value::Object(row)
}

/// Adds the fields of a plain record to a JSON object.
pub(super) fn merge(value: &mut Value, fields: &impl serde::Serialize) {
    let fields = serde_json::to_value(fields).expect("the record is plain data");
    if let (Value::Object(value), Value::Object(fields)) = (value, fields) {
        value.extend(fields);
    }
}
