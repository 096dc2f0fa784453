//! A table of point MDPs written by hand: any features, and either importance or counts.
//!
//! Columns: `point` (optional; numbered when absent), `importance` (sums to 1) or `intersections`
//! (counts, normalised), and one column per feature. A column name that ends in a known unit
//! (`_m`, `_mph`, `_vph`, `_s`, `_kg`) tells the feature's unit.

use super::approaches::csv_error;
use super::{Feature, MdpFamily, PointMdp};
use crate::error::FamilyError;

const UNITS: [(&str, &str); 6] = [
    ("_m", "m"),
    ("_mph", "mph"),
    ("_vph", "veh/h per approach"),
    ("_s", "s"),
    ("_kg", "kg"),
    ("_lanes", "lanes per approach"),
];

/// Name of a file that lies beside the folders of point MDPs.
const RESERVED: &str = "INDEX.csv";

/// Most characters in the id of a point MDP.
pub const MAX_ID: usize = 100;

/// Reads a table of point MDPs.
///
/// # Errors
///
/// [`FamilyError`] naming file and line: a missing or doubled column, a value that is not a
/// non-negative number, an id that is unsafe or doubled, importance that does not sum to 1.
pub fn read(name: &str, text: &str, file: &str) -> Result<MdpFamily, FamilyError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let headers = reader.headers().map_err(|e| csv_error(file, &e))?.clone();
    if headers.is_empty() {
        return Err(FamilyError::Empty { file: file.to_owned() });
    }
    let columns = Columns::parse(&headers).map_err(|m| at(file, 1, m))?;
    let mut points: Vec<PointMdp> = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|e| csv_error(file, &e))?;
        let line = record.position().map_or(0, csv::Position::line);
        let point = columns.point(&record, row).map_err(|m| at(file, line, m))?;
        if points.iter().any(|p| p.id == point.id) {
            return Err(at(file, line, format!("point {} stands twice in the table", point.id)));
        }
        points.push(point);
    }
    if columns.importance.is_none() {
        let total: f64 = points.iter().map(|p| p.importance).sum();
        if !points.is_empty() && total <= 0.0 {
            return Err(at(file, 1, "all `intersections` are 0; give counts".to_owned()));
        }
        for p in &mut points {
            p.importance /= total;
        }
    }
    MdpFamily::new(name, columns.features(), points, file)
}

fn at(file: &str, line: u64, message: String) -> FamilyError {
    FamilyError::Csv { file: file.to_owned(), line, message }
}

struct Columns {
    point: Option<usize>,
    importance: Option<usize>,
    instances: Option<usize>,
    features: Vec<(usize, String)>,
}

impl Columns {
    fn parse(headers: &csv::StringRecord) -> Result<Self, String> {
        let mut columns = Self { point: None, importance: None, instances: None, features: vec![] };
        for (i, name) in headers.iter().enumerate() {
            if headers.iter().take(i).any(|earlier| earlier == name) {
                return Err(format!("column {name} stands twice"));
            }
            match name {
                "" => return Err(format!("column {} has no name", i + 1)),
                "point" => columns.point = Some(i),
                "importance" => columns.importance = Some(i),
                "intersections" => columns.instances = Some(i),
                _ => columns.features.push((i, name.to_owned())),
            }
        }
        if columns.importance.is_none() && columns.instances.is_none() {
            return Err("a column `importance` or `intersections` is needed".into());
        }
        if columns.features.is_empty() {
            return Err("at least one column with a feature is needed".into());
        }
        Ok(columns)
    }

    fn point(&self, record: &csv::StringRecord, row: usize) -> Result<PointMdp, String> {
        let number = |i: usize, name: &str| -> Result<f64, String> {
            let text = record.get(i).unwrap_or_default();
            match text.parse::<f64>() {
                Ok(v) if v.is_finite() && v >= 0.0 => Ok(v),
                _ => Err(format!("{name} = {text:?}: expected a number that is not negative")),
            }
        };
        let id = match self.point {
            Some(i) => record.get(i).unwrap_or_default().to_owned(),
            None => format!("p{:04}", row + 1),
        };
        check_id("point", &id)?;
        let instances = match self.instances {
            Some(i) => {
                let value = number(i, "intersections")?;
                if value.fract() != 0.0 || value > f64::from(u32::MAX) {
                    return Err(format!("intersections = {value}: expected a whole number"));
                }
                value as u32
            }
            None => 1,
        };
        let importance = match self.importance {
            Some(i) => number(i, "importance")?,
            None => f64::from(instances),
        };
        let features = self
            .features
            .iter()
            .map(|(i, name)| number(*i, name))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(PointMdp { id, features, importance, instances })
    }

    fn features(&self) -> Vec<Feature> {
        self.features.iter().map(|(_, name)| feature(name)).collect()
    }
}

fn feature(name: &str) -> Feature {
    let unit = UNITS.iter().find(|(suffix, _)| name.ends_with(suffix)).map_or("", |(_, u)| u);
    Feature { name: name.to_owned(), unit: unit.to_owned() }
}

/// Checks that an id is safe as a file name.
///
/// # Errors
///
/// What was expected, after what the id is of and the id itself.
pub fn check_id(what: &str, id: &str) -> Result<(), String> {
    let safe = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if id.eq_ignore_ascii_case(RESERVED) {
        return Err(format!("{what} {id:?}: the index of networks is called so; choose another"));
    }
    if id.is_empty() || id.len() > MAX_ID || !id.chars().all(safe) || id.starts_with('.') {
        return Err(format!(
            "{what} {id:?}: expected 1 to {MAX_ID} letters, digits, `-`, `_` or `.`, not starting \
             with `.`"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        read("f", text, "p.csv").unwrap_err().to_string()
    }

    #[test]
    fn any_number_of_features_is_read_with_units() {
        let family =
            read("f", "point,importance,mass_kg,length_m\na,0.5,1,2\nb,0.5,3,4\n", "p.csv");
        let family = family.unwrap();
        assert_eq!(family.features[0], Feature { name: "mass_kg".into(), unit: "kg".into() });
        assert_eq!(family.points[1].features, [3.0, 4.0]);
    }

    #[test]
    fn counts_become_importance() {
        let family = read("f", "intersections,x\n3,1\n1,2\n", "p.csv").unwrap();
        assert_eq!(family.importance(), [0.75, 0.25]);
        assert_eq!(family.points[0].id, "p0001");
    }

    #[test]
    fn a_negative_feature_names_line_and_value() {
        assert_eq!(
            error("importance,x\n1,-2\n"),
            "p.csv, line 2: x = \"-2\": expected a number that is not negative"
        );
    }

    #[test]
    fn importance_that_does_not_sum_to_one_says_what_to_do() {
        assert!(error("importance,x\n0.4,1\n0.4,2\n").contains("sums to 0.8, not to 1; divide"));
    }

    #[test]
    fn an_id_that_leaves_the_folder_is_refused() {
        assert!(error("point,importance,x\n../a,1,1\n").contains("point \"../a\""));
    }

    #[test]
    fn the_name_of_the_index_is_no_id() {
        assert!(error("point,importance,x\nindex.csv,1,1\n").contains("point \"index.csv\""));
    }

    #[test]
    fn a_doubled_point_is_refused() {
        assert!(error("point,importance,x\na,0.5,1\na,0.5,1\n").contains("stands twice"));
    }
}
