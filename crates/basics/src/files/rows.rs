//! Rows of tables as text.

use crate::plain::cell;

/// Returns rows as they stand in a table of comma-separated text.
pub fn lines<R: AsRef<[C]>, C: AsRef<str>>(rows: &[R]) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    let in_memory = "writing rows to memory cannot fail";
    for row in rows {
        let cells = row.as_ref().iter().map(|text| cell(text.as_ref()).into_owned());
        writer.write_record(cells).expect(in_memory);
    }
    writer.into_inner().expect(in_memory)
}
