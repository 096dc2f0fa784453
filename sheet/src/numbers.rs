//! Numbers with decimal points, decimal commas, and what may be thousands.

use csv::StringRecord;

/// Digits of a group of thousands.
const GROUP: usize = 3;

/// What the numbers of a column have between digits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Numbers {
    /// Something is no number.
    pub(super) text: bool,
    /// One has a point, or a comma, that can only stand before decimals.
    pub(super) point: bool,
    pub(super) comma: bool,
    /// One may have a point between thousands.
    pub(super) grouped: bool,
    /// A point may separate thousands, as other columns have decimal commas.
    pub(super) doubtful: bool,
}

impl Numbers {
    /// Returns those of every column.
    pub(super) fn columns<'a>(
        rows: impl Iterator<Item = &'a StringRecord>,
        separator: u8,
    ) -> Vec<Self> {
        let mut columns: Vec<Self> = Vec::new();
        for row in rows {
            columns.resize(columns.len().max(row.len()), Self::default());
            for (column, field) in columns.iter_mut().zip(row).filter(|(_, f)| !f.is_empty()) {
                match kind(field) {
                    Kind::Text => column.text = true,
                    Kind::Point => column.point = true,
                    Kind::Comma => column.comma = true,
                    Kind::Grouped => column.grouped |= field.contains('.'),
                    Kind::Whole => {}
                }
            }
        }
        // Between commas, "10,7" may be a list; elsewhere it shows decimal commas.
        let commas = separator != b',' && columns.iter().any(|c| c.comma && !c.text && !c.point);
        for column in &mut columns {
            column.doubtful = commas && column.grouped && !column.point;
        }
        columns
    }

    /// Returns the number that a field holds.
    ///
    /// # Errors
    ///
    /// The way out, for what is no finite number or may be two.
    pub(super) fn number(self, text: &str) -> Result<f64, &'static str> {
        let plain = match (text.contains(','), text.contains('.')) {
            (false, true) if !self.doubtful && (self.point || !self.comma) => text.to_owned(),
            (true, false) if self.comma && !self.point && text.matches(',').count() == 1 => {
                text.replace(',', ".")
            }
            (false, false) => text.to_owned(),
            _ => return Err("write numbers with a point and without thousands separators"),
        };
        let number = plain.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or("write a number such as 40.78")
    }

    /// Returns whether one clearly has decimals.
    pub(super) fn have_decimals(self) -> bool {
        self.point || self.comma
    }

    /// Returns the number of what is many, such as vehicles: a separator before three digits may be one of thousands
    /// there, unless others `have_decimals`.
    ///
    /// # Errors
    ///
    /// The way out, for what is no finite number or may be two.
    pub(super) fn count(self, text: &str, have_decimals: bool) -> Result<f64, String> {
        let number = self.number(text)?;
        if have_decimals || !matches!(kind(text), Kind::Grouped) {
            return Ok(number);
        }
        let whole = text.replace([',', '.'], "");
        Err(format!(
            "{whole} if the separator is one of thousands, {number} if decimals follow; write {whole} or {number:.4}"
        ))
    }
}

enum Kind {
    Text,
    Whole,
    /// With a point or comma that may separate thousands as well.
    Grouped,
    Point,
    Comma,
}

fn kind(field: &str) -> Kind {
    let digits = field.strip_prefix(['+', '-']).unwrap_or(field);
    let number = |c: char| c.is_ascii_digit() || ".,".contains(c);
    if !digits.chars().all(number) || !digits.contains(|c: char| c.is_ascii_digit()) {
        return Kind::Text;
    }
    let Some((before, after)) = digits.split_once([',', '.']) else { return Kind::Whole };
    let thousands =
        after.len() == GROUP && (1..=GROUP).contains(&before.len()) && !before.starts_with('0');
    match digits.contains(',') {
        _ if thousands || after.contains([',', '.']) => Kind::Grouped,
        true => Kind::Comma,
        false => Kind::Point,
    }
}
