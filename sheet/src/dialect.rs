//! What separates the columns of a table and the decimals of its numbers.

use csv::{ReaderBuilder, StringRecord, Trim};

use super::fault::Fault;

/// Separators of columns and their names.
const SEPARATORS: [(u8, &str); 4] =
    [(b',', "commas"), (b';', "semicolons"), (b'\t', "tabs"), (b'|', "bars")];

/// Rows that decide between two separators.
const ROWS_LOOKED_AT: usize = 50;

/// Digits of a group of thousands.
const GROUP: usize = 3;

/// What separates whole digits from decimals, as far as the table shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Decimals {
    /// A point, or there are none.
    Point,
    /// A comma, throughout.
    Comma,
    /// Both occur.
    Mixed,
}

/// Returns a reader of text whose columns are separated like this.
pub(super) fn reader<R: std::io::Read>(separator: u8, text: R) -> csv::Reader<R> {
    let mut builder = ReaderBuilder::new();
    builder.trim(Trim::All).flexible(true).delimiter(separator).comment(Some(b'#'));
    builder.from_reader(text)
}

/// Returns a field without the apostrophe before what begins like a formula, with which tables are written so that no
/// spreadsheet computes it.
pub(super) fn uncomputed(field: &str) -> &str {
    let text = field.strip_prefix('\'').filter(|text| text.starts_with(['=', '+', '-', '@']));
    text.unwrap_or(field)
}

/// Returns the separator that Excel writes into a line of its own, and the bytes of that line.
pub(super) fn said(text: &str) -> Option<(u8, usize)> {
    let line = text.lines().next()?;
    let separator = line.trim().trim_matches('"').strip_prefix("sep=")?;
    let separator = if separator.is_empty() { "\t" } else { separator };
    let known = SEPARATORS.iter().find(|(byte, _)| separator.as_bytes() == [*byte])?;
    Some((known.0, line.len()))
}

/// Returns what separates the columns: of the separators in the first line the one with which all
/// rows have as many fields as it has names, else the one with the most columns.
///
/// # Errors
///
/// [`Fault`] when two would do.
pub(super) fn separator(text: &str) -> Result<u8, Fault> {
    let mut candidates = Vec::new();
    for (byte, name) in SEPARATORS {
        let mut reader = reader(byte, text.as_bytes());
        let columns = reader.headers().map_or(0, StringRecord::len);
        if columns < 2 {
            continue;
        }
        let rows = reader.records().take(ROWS_LOOKED_AT).filter_map(Result::ok);
        let mut rows = rows.filter(|row| !row.iter().all(str::is_empty));
        candidates.push((rows.all(|row| row.len() == columns), columns, byte, name));
    }
    candidates.sort_by_key(|(fits, columns, byte, _)| (!fits, usize::MAX - columns, *byte));
    match candidates.as_slice() {
        [] => Ok(b','),
        [(true, columns, _, name), (true, others, _, other), ..] if columns == others => {
            let message = format!(
                "the columns may be separated by {name} or by {other}; put texts that contain one \
                 of them in quotes"
            );
            Err(Fault { line: 1, message })
        }
        [(_, _, byte, _), ..] => Ok(*byte),
    }
}

/// What the numbers of a column show of its decimals.
#[derive(Debug, Clone, Copy, Default)]
struct Evidence {
    text: bool,
    point: bool,
    comma: bool,
}

/// Returns what separates decimals, from all columns that hold nothing but numbers.
pub(super) fn decimals(text: &str, separator: u8) -> Decimals {
    // Between commas, a number with a comma needs quotes.
    if !text.contains(if separator == b',' { '"' } else { ',' }) {
        return Decimals::Point;
    }
    let mut reader = reader(separator, text.as_bytes());
    let mut columns: Vec<Evidence> = Vec::new();
    for row in reader.records().filter_map(Result::ok) {
        columns.resize(columns.len().max(row.len()), Evidence::default());
        for (column, field) in columns.iter_mut().zip(&row).filter(|(_, f)| !f.is_empty()) {
            match kind(field) {
                Kind::Text => column.text = true,
                Kind::Point => column.point = true,
                Kind::Comma => column.comma = true,
                Kind::Whole | Kind::Grouped => {}
            }
        }
    }
    let numbers = columns.iter().filter(|c| !c.text);
    match numbers.fold((false, false), |(p, c), e| (p || e.point, c || e.comma)) {
        (_, false) => Decimals::Point,
        (false, true) => Decimals::Comma,
        (true, true) => Decimals::Mixed,
    }
}

/// Returns per column whether one of its numbers [`has_decimals`]; nothing for a table without any number
/// that may have a separator between thousands, of which nobody asks.
pub(super) fn with_decimals(text: &str, separator: u8) -> Vec<bool> {
    let digit = |at: Option<usize>| {
        at.and_then(|at| text.as_bytes().get(at)).is_some_and(u8::is_ascii_digit)
    };
    let before_three = |at: usize| (1..=GROUP).all(|i| digit(Some(at + i)));
    let may_separate =
        |at: usize| digit(at.checked_sub(1)) && before_three(at) && !digit(Some(at + GROUP + 1));
    if !text.match_indices(['.', ',']).any(|(at, _)| may_separate(at)) {
        return Vec::new();
    }
    let mut columns = Vec::new();
    for row in reader(separator, text.as_bytes()).records().filter_map(Result::ok) {
        columns.resize(columns.len().max(row.len()), false);
        for (shown, field) in columns.iter_mut().zip(&row) {
            *shown |= has_decimals(field);
        }
    }
    columns
}

/// Returns whether a text is a number with a separator that can only stand before decimals: `0.125`, not
/// `12.300`.
pub fn has_decimals(field: &str) -> bool {
    matches!(kind(field), Kind::Point | Kind::Comma)
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
    if after.contains([',', '.']) || may_be_thousands(before, after) {
        return Kind::Grouped;
    }
    if digits.contains(',') { Kind::Comma } else { Kind::Point }
}

/// Whether digits before and after a separator may be thousands and the rest: `1,234`.
fn may_be_thousands(before: &str, after: &str) -> bool {
    after.len() == GROUP && (1..=GROUP).contains(&before.len()) && !before.starts_with('0')
}

/// Returns a field's number.
///
/// # Errors
///
/// The way out, for what is no finite number or may be two.
pub(super) fn number(text: &str, decimals: Decimals) -> Result<f64, &'static str> {
    const POINT: &str = "write numbers with a point and without thousands separators";
    const MIXED: &str = "some numbers of the table have a decimal point and others a decimal \
                         comma; write all with a point and without thousands separators";
    let parsed = |text: &str| match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("write a number such as 40.78"),
    };
    match (text.contains(','), text.contains('.'), decimals) {
        (false, false, _) | (false, true, Decimals::Point) => parsed(text),
        (true, false, Decimals::Comma) if text.matches(',').count() == 1 => {
            parsed(&text.replace(',', "."))
        }
        // With decimal commas, a point may separate thousands.
        (false, true, Decimals::Mixed) if !matches!(kind(text), Kind::Grouped) => parsed(text),
        (_, _, Decimals::Mixed) => Err(MIXED),
        _ => Err(POINT),
    }
}

/// Returns the number of what is many, such as vehicles: a separator before three digits may be one of
/// thousands there, unless other numbers of the column `have_decimals`.
///
/// # Errors
///
/// The way out, for what is no finite number or may be two.
pub(super) fn count(text: &str, decimals: Decimals, have_decimals: bool) -> Result<f64, String> {
    let number = number(text, decimals)?;
    let Some(at) = text.find([',', '.']) else { return Ok(number) };
    if have_decimals || !matches!(kind(text), Kind::Grouped) {
        return Ok(number);
    }
    let (separator, name) = match &text[at..=at] {
        "," => (",", "comma"),
        other => (other, "point"),
    };
    let whole = text.replace(separator, "");
    let zeros = text.trim_end_matches('0').trim_end_matches(separator);
    // With all three digits it would have two meanings again.
    let fraction = if zeros.len() == text.len() { format!("{text}0") } else { zeros.to_owned() };
    Err(format!(
        "{whole} if the {name} separates thousands, {number} if it separates decimals; write {whole} \
         or {fraction}"
    ))
}
