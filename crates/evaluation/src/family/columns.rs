//! The columns of a table by their names, and the numbers in them.

use csv::StringRecord;
use sheet::{Fault, Row};

use crate::family::error::FamilyError;
use basics::suggest::{did_you_mean, similar};

/// Returns the error for what is wrong at a line of a table.
pub fn at(file: &str, fault: Fault) -> FamilyError {
    FamilyError::Csv { file: file.to_owned(), line: fault.line, message: fault.message }
}

/// Where columns are. Names are the same in large and small letters, because spreadsheets and databases change them.
pub struct Columns(Vec<(String, usize)>);

impl Columns {
    /// Returns the columns of a table, which has to have some and may have others, of which some are known.
    pub fn find(headers: &StringRecord, needed: &[&str], known: &[&str]) -> Result<Self, String> {
        for (i, name) in headers.iter().enumerate() {
            if name.is_empty() {
                return Err(format!("column {} has no name; give it one or remove it", i + 1));
            }
            if headers.iter().take(i).any(|earlier| earlier.eq_ignore_ascii_case(name)) {
                return Err(format!("column {name} stands twice; remove or rename one of the two"));
            }
        }
        let is_known =
            |name: &&str| needed.iter().chain(known).any(|n| n.eq_ignore_ascii_case(name));
        let others = || headers.iter().filter(|name| !is_known(name));
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

    fn at(&self, name: &str) -> usize {
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

/// Ends of the names of columns, what they measure, and how much of its first unit one of them is.
const UNITS: [(&str, &str, f64); 14] = [
    ("_mph", "speed", 1.0),
    ("_kmh", "speed", 0.621_371),
    ("_kph", "speed", 0.621_371),
    ("_km_h", "speed", 0.621_371),
    ("_mps", "speed", 2.236_936),
    ("_m_s", "speed", 2.236_936),
    ("_m", "length", 1.0),
    ("_ft", "length", 0.3048),
    ("_yd", "length", 0.9144),
    ("_km", "length", 1000.0),
    ("_mi", "length", 1609.344),
    ("_kg", "mass", 1.0),
    ("_g", "mass", 0.001),
    ("_lb", "mass", 0.453_592),
];

/// End of the name of a column of what one lane has.
const PER_LANE: &str = "_per_lane";

/// Says how a column becomes the one that is missing; `None` where renaming it is all.
fn conversion(missing: &str, other: &str) -> Option<String> {
    if missing.ends_with(PER_LANE) && !other.to_lowercase().contains("lane") {
        return Some(format!(
            "the column {other} seems to be of all lanes: divide it by the lanes that it counts, those of both \
             directions, and call it {missing}"
        ));
    }
    let ((_, measure, one), (_, other_measure, other_one)) = (unit(missing)?, unit(other)?);
    (measure == other_measure && one != other_one).then(|| {
        let factor = (other_one / one * 1e6).round() / 1e6;
        format!(
            "the column {other} has another unit: multiply it by {factor} and call it {missing}"
        )
    })
}

/// Returns the unit that a name ends in, the longest of those that fit.
fn unit(name: &str) -> Option<(&'static str, &'static str, f64)> {
    let name = name.to_lowercase();
    UNITS.into_iter().filter(|(end, ..)| name.ends_with(end)).max_by_key(|(end, ..)| end.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_unit_comes_with_its_factor() {
        let said = |missing, other| conversion(missing, other).unwrap();
        assert_eq!(
            said("speed_mph", "speed_kmh"),
            "the column speed_kmh has another unit: multiply it by 0.621371 and call it speed_mph"
        );
        assert!(said("length_m", "length_ft").contains("multiply it by 0.3048 "));
        assert!(said("speed_mph", "Speed_m_s").contains("multiply it by 2.236936 "));
        assert!(
            said("aadt_veh_per_day_per_lane", "aadt")
                .contains("divide it by the lanes that it counts")
        );
    }

    #[test]
    fn a_name_without_another_unit_is_no_conversion() {
        for (missing, other) in
            [("speed_mph", "speed"), ("length_m", "Length_m"), ("speed_mph", "spede_mph")]
        {
            assert_eq!(conversion(missing, other), None, "{other}");
        }
        assert_eq!(conversion("aadt_veh_per_day_per_lane", "aadt_per_lane"), None);
    }
}
