//! Rows of tables as text.

use std::fmt::Display;
use std::io::Write;

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

/// A table that is written cell after cell, as [`lines`] would write its rows, without a text of its own for each. A row has
/// two cells or more.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    text: Vec<u8>,
    /// Whether the row has a cell already.
    is_begun: bool,
}

impl Lines {
    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.next();
        let cell = cell(text);
        let plain = !cell.bytes().any(|byte| b",\"\r\n".contains(&byte));
        if plain {
            return self.text.extend(cell.as_bytes());
        }
        self.text.push(b'"');
        for byte in cell.bytes() {
            self.text.extend((byte == b'"').then_some(b'"'));
            self.text.push(byte);
        }
        self.text.push(b'"');
    }

    /// Adds a number as the shortest text that reads back as the same; nothing stands where there is none.
    pub fn number(&mut self, cell: Option<f64>) {
        self.next();
        cell.into_iter().for_each(|number| self.show(number));
    }

    /// Adds a whole number.
    pub fn whole(&mut self, cell: u64) {
        self.next();
        self.show(cell);
    }

    /// Ends the row.
    pub fn end(&mut self) {
        self.text.push(b'\n');
        self.is_begun = false;
    }

    /// Returns the text.
    pub fn into_bytes(self) -> Vec<u8> {
        self.text
    }

    fn next(&mut self) {
        self.text.extend(self.is_begun.then_some(b','));
        self.is_begun = true;
    }

    fn show(&mut self, cell: impl Display) {
        write!(self.text, "{cell}").expect("writing to memory cannot fail");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_one_by_one_are_the_same_as_rows() {
        let texts = ["", "a b", "a,b", "say \"no\"", "\"", "two\nlines", "\r", "ü", "'"];
        let numbers = [0.0, -0.0, 1.5e-7, 1e21, 0.1 + 0.2, -3.0];
        let mut one_by_one = Lines::default();
        let mut rows = Vec::new();
        for (i, text) in texts.into_iter().enumerate() {
            let number = numbers.get(i).copied();
            one_by_one.text(text);
            one_by_one.number(number);
            one_by_one.whole(u64::MAX - i as u64);
            one_by_one.end();
            let number = number.map_or_else(String::new, |number| number.to_string());
            rows.push([text.to_owned(), number, (u64::MAX - i as u64).to_string()]);
        }
        assert_eq!(one_by_one.into_bytes(), lines(&rows));
    }
}
