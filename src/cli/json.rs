//! Lines of `--json`.

use serde_json::{Value, json};

use crate::report::JsonRow;

/// Returns a method as `--json` prints it.
pub(super) fn method_line(row: &JsonRow) -> Value {
    let mut value = json!({"event": "method"});
    merge(&mut value, row);
    value
}

/// Adds the fields of a plain record to a JSON object.
pub(super) fn merge(value: &mut Value, fields: &impl serde::Serialize) {
    let fields = serde_json::to_value(fields).expect("the record is plain data");
    if let (Value::Object(value), Value::Object(fields)) = (value, fields) {
        value.extend(fields);
    }
}
