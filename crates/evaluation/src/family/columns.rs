//! The columns of a table by their names, and the numbers in them.

use csv::StringRecord;
use sheet::{Fault, Row};

use crate::family::error::FamilyError;
use crate::family::similar_unit::conversion;
use basics::suggest::{did_you_mean, similar};

/// Returns the error for what is wrong at a line of a table.
pub fn at(file: &str, fault: Fault) -> FamilyError {
    FamilyError::Csv { file: file.to_owned(), line: fault.line, message: fault.message }
}

/// Where columns are. Names are the same in large and small letters, because spreadsheets and databases change them.
pub struct Columns(Vec<(String, usize)>);

impl Columns {
    /// Returns the columns of a table, which has to have some and may have others.
    pub fn find(headers: &StringRecord, needed: &[&str]) -> Result<Self, String> {
        for (i, name) in headers.iter().enumerate() {
            if name.is_empty() {
                return Err(format!("column {} has no name; give it one or remove it", i + 1));
            }
            if headers.iter().take(i).any(|earlier| earlier.eq_ignore_ascii_case(name)) {
                return Err(format!("column {name} stands twice; remove or rename one of the two"));
            }
        }
        let is_needed = |name: &&str| needed.iter().any(|n| n.eq_ignore_ascii_case(name));
        let others = || headers.iter().filter(|name| !is_needed(name));
        for name in needed {
            if !headers.iter().any(|header| header.eq_ignore_ascii_case(name)) {
                let way_out = match headers.iter().any(|h| h.parse::<f64>().is_ok()) {
                    true => "; the first line seems to hold values: put a line with the names of \
                             the columns before it"
                        .to_owned(),
                    false => match similar(name, others()).first() {
                        None => "; add it".to_owned(),
                        Some(other) => match conversion(name, other) {
                            Some(conversion) => format!("; {conversion}"),
                            None => format!("; if it is the column {other}, rename that"),
                        },
                    },
                };
                return Err(format!("no column {name}{way_out}"));
            }
        }
        let called = |name: &str| {
            let needed = needed.iter().find(|n| n.eq_ignore_ascii_case(name));
            needed.map_or(name, |needed| needed).to_owned()
        };
        Ok(Self(headers.iter().enumerate().map(|(i, name)| (called(name), i)).collect()))
    }

    /// Refuses columns that are none of these.
    ///
    /// # Errors
    ///
    /// The name of the first such column, and the way out.
    pub fn only(&self, known: &[&str]) -> Result<(), String> {
        let is_known = |name: &str| known.iter().any(|k| k.eq_ignore_ascii_case(name));
        match self.0.iter().find(|(name, _)| !is_known(name)) {
            None => Ok(()),
            Some((name, _)) => {
                let meant = did_you_mean(name, known.iter().copied());
                Err(format!("unknown column {name}; rename or remove it{meant}"))
            }
        }
    }

    /// Returns where a column is that may be missing.
    pub fn get(&self, name: &str) -> Option<usize> {
        self.0.iter().find(|(column, _)| column.eq_ignore_ascii_case(name)).map(|(_, i)| *i)
    }

    /// Returns where a column is.
    pub fn at(&self, name: &str) -> usize {
        self.get(name).expect("the column was looked for")
    }

    /// Returns the names of all columns, in the order of the table.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    /// Returns a field's number; `None` if it is empty.
    pub fn optional(&self, row: &Row, name: &str) -> Result<Option<f64>, String> {
        let at = self.at(name);
        row.number(at).map_err(|way_out| format!("{name} = {:?}: {way_out}", row.text(at)))
    }

    /// Returns a field's number.
    pub fn number(&self, row: &Row, name: &str) -> Result<f64, String> {
        self.optional(row, name)?.ok_or_else(|| format!("{name} is empty; give a number"))
    }

    /// Returns a field's number of what is many, such as vehicles; `None` if it is empty.
    pub fn optional_count(&self, row: &Row, name: &str) -> Result<Option<f64>, String> {
        let at = self.at(name);
        row.count(at).map_err(|way_out| format!("{name} = {:?}: {way_out}", row.text(at)))
    }

    /// Returns a field's number of what is many, such as vehicles.
    pub fn count(&self, row: &Row, name: &str) -> Result<f64, String> {
        self.optional_count(row, name)?.ok_or_else(|| format!("{name} is empty; give a number"))
    }

    /// Returns a field's whole number.
    pub fn whole(&self, row: &Row, name: &str) -> Result<u32, String> {
        let wrong = || {
            let text = row.text(self.at(name));
            format!("{name} = {text:?}: expected a whole number that is not negative")
        };
        let number = self.number(row, name).map_err(|e| match row.text(self.at(name)) {
            "" => e,
            text if text.contains([',', '.']) => e,
            _ => wrong(),
        })?;
        let whole = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
        if whole { Ok(number as u32) } else { Err(wrong()) }
    }
}
