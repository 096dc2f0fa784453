//! Which property or column of a file holds the counts, and what its values mean.

use geojson::JsonValue;

use crate::error::brief;

/// What names of counts have in common.
const AADT: &str = "aadt";

/// What names have that are not of the vehicles of a day: when a count is from (`DOT_AADTYR`), only trucks
/// (`AADT_SINGLE_UNIT`), another year's forecast.
const OTHER: [&str; 12] = [
    "yr", "year", "date", "truck", "heavy", "single", "combination", "peak", "future", "forecast",
    "proj", "design",
];

/// Years that a name can mean.
const YEARS: std::ops::RangeInclusive<u32> = 1950..=2099;

/// Year of this version: a count of a later year is a forecast. It is not the year of the clock, so that a file is read
/// alike on every day.
const THIS_YEAR: u32 = 2026;

/// Usual names of the column or property with the year of a count.
pub(super) const YEAR: [&str; 7] =
    ["year", "yr", "aadt_year", "aadt_yr", "aadtyr", "count_year", "year_record"];

/// Most names that a message lists.
const LISTED: usize = 30;

/// A name, and one of its values if none is usable.
pub(super) type Name<'a> = (&'a str, Option<String>);

/// Returns the name of the counts among all names.
///
/// # Errors
///
/// What is wrong, the names to choose from, and the way out.
pub(super) fn choose(names: &[Name<'_>], given: Option<&str>) -> Result<String, String> {
    if let Some(given) = given {
        let exact = names.iter().find(|(n, _)| *n == given);
        let mut alike = names.iter().filter(|(n, _)| n.eq_ignore_ascii_case(given));
        return match (exact, alike.next(), alike.next()) {
            (Some((name, _)), ..) | (None, Some((name, _)), None) => Ok((*name).to_owned()),
            _ => {
                let given = brief(given);
                Err(format!("nothing is named {given:?} (given as field); {}", listed(names)))
            }
        };
    }
    let is = |name: &str| {
        let lower = name.to_lowercase();
        let is_past = year(name).is_none_or(|year| year <= THIS_YEAR);
        lower.contains(AADT) && is_past && !OTHER.iter().any(|w| lower.contains(w))
    };
    let (named, unusable): (Vec<_>, Vec<_>) =
        names.iter().filter(|n| is(n.0)).partition(|(_, unusable)| unusable.is_none());
    let named: Vec<_> = named.into_iter().map(|n| n.0).collect();
    let first: Vec<_> = named.iter().filter(|n| n.to_lowercase().starts_with(AADT)).collect();
    if let [only] = first[..] {
        return Ok((*only).to_owned());
    }
    let latest = named.iter().filter_map(|n| year(n)).max();
    let of_latest: Vec<_> = named.iter().filter(|n| year(n) == latest).collect();
    let plain = latest.map_or_else(|| AADT.to_owned(), |year| format!("{AADT}{year}"));
    let mut best = of_latest.iter().filter(|n| n.to_lowercase().replace('_', "") == plain);
    match (&of_latest[..], best.next(), best.next()) {
        ([only], ..) | (_, Some(only), None) => Ok((**only).to_owned()),
        ([], ..) => Err(match &unusable[..] {
            [] => match names.iter().find(|n| n.0.to_lowercase().contains(AADT)) {
                None => format!("no name has AADT in it; {}", listed(names)),
                Some((name, _)) => format!(
                    "{} looks like a forecast or like some of the vehicles; {}",
                    brief(name),
                    listed(names)
                ),
            },
            [(name, value), ..] => format!(
                "{} has no usable value (such as {}); {}",
                brief(name),
                brief(value.as_deref().unwrap_or_default()),
                listed(names)
            ),
        }),
        _ => {
            let several: Vec<_> = of_latest.iter().take(LISTED).map(|n| brief(n)).collect();
            Err(format!(
                "several names could be the count ({}); give one as `field`",
                several.join(", ")
            ))
        }
    }
}

/// Why a value is no count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum NoCount {
    /// It counts nothing; a reason of [`Oddities`](crate::oddities::Oddities).
    Skipped(&'static str),
    /// It may be two numbers or has thousands separators; the way out.
    Refused(String),
}

/// Returns a count of vehicles per day.
///
/// # Arguments
///
/// * `have_decimals`: whether texts beside it show that they have decimals.
/// * `of_year`: the year beside it, if there is one.
///
/// # Errors
///
/// Why it is none.
pub(super) fn count(
    value: Option<&JsonValue>,
    have_decimals: bool,
    of_year: Option<&str>,
) -> Result<f64, NoCount> {
    if of_year.and_then(year).is_some_and(|year| year > THIS_YEAR) {
        return Err(NoCount::Skipped("forecast of a year to come"));
    }
    let number = match value {
        None | Some(JsonValue::Null) => return Err(NoCount::Skipped("missing count")),
        Some(JsonValue::Number(number)) => number.as_f64(),
        Some(JsonValue::String(text)) => match text.trim() {
            "" => return Err(NoCount::Skipped("missing count")),
            text if is_grouped(text) => text.replace(is_group_mark, "").parse().ok(),
            text if is_separated(text) => {
                Some(sheet::count(text, have_decimals).map_err(NoCount::Refused)?)
            }
            text => text.parse().ok(),
        },
        Some(_) => None,
    };
    match number.filter(|n: &f64| n.is_finite()) {
        None => Err(NoCount::Skipped("count that is no number")),
        Some(number) if number < 0.0 => Err(NoCount::Skipped("negative count")),
        // Some agencies write 0 where nothing was counted, and no street has no traffic at all.
        Some(0.0) => Err(NoCount::Skipped("count of 0")),
        Some(number) => Ok(number),
    }
}

/// Returns whether a text is a number with a comma or a point.
pub(super) fn is_separated(text: &str) -> bool {
    text.contains([',', '.']) && text.chars().all(|c| c.is_ascii_digit() || "+-.,".contains(c))
}

/// Returns whether a character groups the digits of long numbers and nothing else.
fn is_group_mark(c: char) -> bool {
    matches!(c, ' ' | '\'' | '\u{2019}' | '\u{a0}' | '\u{2009}' | '\u{202f}')
}

/// Returns whether a text is a whole number in groups of three digits with one mark between them, such as `12 300`.
fn is_grouped(text: &str) -> bool {
    let Some(mark) = text.chars().find(|c| is_group_mark(*c)) else { return false };
    let digits = |group: &str| group.chars().all(|c| c.is_ascii_digit());
    let mut groups = text.split(mark);
    groups.next().is_some_and(|first| matches!(first.len(), 1..=3) && digits(first))
        && groups.all(|group| group.len() == 3 && digits(group))
}

/// Returns the year in a name, of several the last one.
fn year(name: &str) -> Option<u32> {
    name.split(|c: char| !c.is_ascii_digit())
        .filter_map(|digits| digits.parse().ok())
        .rfind(|year| YEARS.contains(year))
}

fn listed(names: &[Name<'_>]) -> String {
    let shown: Vec<_> = names.iter().take(LISTED).map(|(name, _)| brief(name)).collect();
    let more = if names.len() > LISTED { ", ..." } else { "" };
    if shown.is_empty() {
        "there is no name at all; export the counts with their attributes".to_owned()
    } else {
        format!("the names are {}{more}; give that of the counts as `field`", shown.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn chosen(names: &[&str]) -> Result<String, String> {
        choose(&names.iter().map(|n| (*n, None)).collect::<Vec<_>>(), None)
    }

    #[test]
    fn the_only_name_or_else_the_latest_year_is_taken() {
        for (names, expected) in [
            (vec!["ROUTE", "AADT"], "AADT"),
            (vec!["aadt", "DOT_AADT"], "aadt"),
            (vec!["DOT_AADT", "DOT_AADTYR"], "DOT_AADT"),
            (vec!["AADT2019", "AADT2021", "AADT2018"], "AADT2021"),
            (vec!["AADT2023_Unrounded", "AADT2024_Unrounded"], "AADT2024_Unrounded"),
            (vec!["AADT2024_Unrounded", "AADT_2024"], "AADT_2024"),
            (vec!["aadt", "aadt_single_unit", "aadt_combination"], "aadt"),
            (vec!["AADT", "AADT2021"], "AADT2021"),
        ] {
            assert_eq!(chosen(&names).as_deref(), Ok(expected));
        }
    }

    #[test]
    fn trucks_and_forecasts_are_no_counts_of_all_vehicles() {
        assert_eq!(chosen(&["AADT_TRUCK", "TOTAL_AADT"]).unwrap(), "TOTAL_AADT");
        assert_eq!(chosen(&["AADT_2023", "FUTURE_AADT_2045"]).unwrap(), "AADT_2023");
        assert!(chosen(&["AADT_SINGLE_UNIT", "AADT_COMBINATION"]).is_err());
        assert_eq!(chosen(&["AADT_2023", "AADT_2045"]).unwrap(), "AADT_2023");
        assert_eq!(chosen(&["AADT2045", "DOT_AADT"]).unwrap(), "DOT_AADT");
        assert_eq!(
            chosen(&["ROUTE", "AADT_2045"]).unwrap_err(),
            "AADT_2045 looks like a forecast or like some of the vehicles; the names are ROUTE, AADT_2045; give that \
             of the counts as `field`"
        );
        assert_eq!(chosen(&["AADT_COMBINED"]).unwrap(), "AADT_COMBINED");
    }

    #[test]
    fn what_cannot_be_decided_lists_the_candidates() {
        assert_eq!(
            chosen(&["AHEAD_AADT", "BACK_AADT"]).unwrap_err(),
            "several names could be the count (AHEAD_AADT, BACK_AADT); give one as `field`"
        );
        assert_eq!(
            chosen(&["ROUTE", "VOLUME"]).unwrap_err(),
            "no name has AADT in it; the names are ROUTE, VOLUME; give that of the counts as \
             `field`"
        );
        assert!(chosen(&[]).unwrap_err().contains("no name at all"));
    }

    #[test]
    fn a_name_without_usable_values_is_no_candidate() {
        let latest = ("AADT2022", Some("null".to_owned()));
        assert_eq!(choose(&[latest.clone(), ("AADT2021", None)], None).unwrap(), "AADT2021");
        assert_eq!(
            choose(&[latest], None).unwrap_err(),
            "AADT2022 has no usable value (such as null); the names are AADT2022; \
             give that of the counts as `field`"
        );
    }

    #[test]
    fn a_given_name_is_taken_whatever_its_case_unless_that_is_unclear() {
        let names = [("Volume", None), ("vol", None), ("VOL", None)];
        assert_eq!(choose(&names, Some("VOLUME")).unwrap(), "Volume");
        assert_eq!(choose(&names, Some("vol")).unwrap(), "vol");
        assert!(choose(&names, Some("Vol")).unwrap_err().contains("nothing is named \"Vol\""));
    }

    #[test]
    fn a_count_is_a_positive_number_also_as_text() {
        let count = |value: Option<&JsonValue>| count(value, false, None);
        assert_eq!(count(Some(&json!(1200))), Ok(1200.0));
        assert_eq!(count(Some(&json!(12.345))), Ok(12.345));
        assert_eq!(count(Some(&json!(" 1200.5 "))), Ok(1200.5));
        for text in ["12 300", "12'300", "12\u{202f}300", "12\u{a0}300", "12\u{2019}300"] {
            assert_eq!(count(Some(&json!(text))), Ok(12_300.0), "{text:?}");
        }
        assert_eq!(count(Some(&json!("1 234 567"))), Ok(1_234_567.0));
        for (value, reason) in [
            (json!("12 30"), "count that is no number"),
            (json!("1234 567"), "count that is no number"),
            (json!("1 234'567"), "count that is no number"),
            (json!(null), "missing count"),
            (json!(" "), "missing count"),
            (json!(-1), "negative count"),
            (json!(0), "count of 0"),
            (json!("NaN"), "count that is no number"),
            (json!("many"), "count that is no number"),
            (json!([1]), "count that is no number"),
        ] {
            assert_eq!(count(Some(&value)), Err(NoCount::Skipped(reason)), "{value}");
        }
        assert_eq!(count(None), Err(NoCount::Skipped("missing count")));
    }
}
