//! Why a scenario or a family is unusable.

use basics::files::FileError;

/// Why a scenario or a family is unusable.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FamilyError {
    /// Neither a file nor an embedded scenario.
    #[error("no scenario {name:?}: neither a file nor an embedded scenario ({embedded}){meant}")]
    UnknownScenario {
        /// What was asked for.
        name: String,
        /// The embedded names.
        embedded: String,
        /// What may have been meant.
        meant: String,
    },
    /// The TOML does not parse or has unknown or missing fields.
    #[error("{file}: {message}")]
    Toml {
        /// The scenario file, with the line where it is known.
        file: String,
        /// What is wrong, with the setting.
        message: String,
    },
    /// A setting from the command line does not exist or has a value of a wrong type.
    #[error("{flag}: {message}")]
    Override {
        /// What the user wrote.
        flag: String,
        /// What is wrong and what is expected.
        message: String,
    },
    /// A setting is out of range.
    #[error("{file}: {field} = {value}: {expected}")]
    Setting {
        /// The scenario file.
        file: String,
        /// Dotted name of the field.
        field: String,
        /// What it is.
        value: String,
        /// What it should be.
        expected: String,
    },
    /// A CSV row or header is wrong.
    #[error("{file}, line {line}: {message}")]
    Csv {
        /// The table.
        file: String,
        /// One-based line.
        line: u64,
        /// What is wrong and what is expected.
        message: String,
    },
    /// A point MDP that cannot be in a family.
    #[error("{file}: point {point:?}: {message}")]
    Point {
        /// The table.
        file: String,
        /// Its id.
        point: String,
        /// What is wrong with it.
        message: String,
    },
    /// The family is not a probability distribution.
    #[error(
        "{file}: importance sums to {sum}, not to 1; divide each value by the sum, or give counts{column} instead"
    )]
    NotADistribution {
        /// The table.
        file: String,
        /// The sum found.
        sum: f64,
        /// In which column counts are given, in words, if there is one.
        column: String,
    },
    /// A family without point MDPs.
    #[error("{file}: no point MDP; the table needs at least one row below its header")]
    Empty {
        /// The table.
        file: String,
    },
    /// A file could not be read.
    #[error(transparent)]
    Io(#[from] FileError),
}

impl FamilyError {
    /// Returns the error of a setting that is not what is expected.
    pub fn setting(
        file: &str,
        field: impl Into<String>,
        value: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let file = file.to_owned();
        Self::Setting { file, field: field.into(), value: value.into(), expected: expected.into() }
    }
}
