//! CSV: a cell is empty where nothing was measured; it is never 0 for that reason. The last column of tables with a column
//! `point` is its `title`, where point MDPs are called otherwise than by their ids.

use basics::plain::cell;

/// Returns the shortest text that reads back as the same number.
pub fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

/// A table whose rows are each of a point MDP, with what that is called where it is not its id.
///
/// It is made of what point MDPs are called, by their positions; of nothing when all are called by their ids.
#[derive(Clone, Copy)]
pub struct Titled<'a>(pub Option<&'a [String]>);

impl Titled<'_> {
    /// Returns the header, with the column of titles if there is one.
    pub fn header(self, mut header: Vec<String>) -> Vec<String> {
        header.extend(self.0.map(|_| "title".to_owned()));
        header
    }

    /// Returns a row of the point MDP at a position.
    pub fn row(self, point: usize, mut cells: Vec<String>) -> Vec<String> {
        cells.extend(self.0.map(|titles| titles[point].clone()));
        cells
    }
}

/// Returns a table; every row has as many cells as the header.
pub fn table<H: AsRef<str>>(header: &[H], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let in_memory = "writing rows of equal length to memory cannot fail";
    let header = header.iter().map(|name| cell(name.as_ref()).into_owned());
    writer.write_record(header).expect(in_memory);
    for row in rows {
        writer.write_record(row.iter().map(|text| cell(text).into_owned())).expect(in_memory);
    }
    String::from_utf8(writer.into_inner().expect(in_memory)).expect("strings are UTF-8")
}
