//! Which property or column of a file holds the counts, and what its values mean.

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

/// Returns the name of the counts among all names: the one given, or that with AADT in it, of several that of the latest
/// year, and of these `AADT` or `AADT2021` itself.
///
/// # Errors
///
/// What is wrong, the names to choose from, and the way out.
pub(super) fn choose(names: &[&str], given: Option<&str>) -> Result<String, String> {
    let plain = |name: &str| name.to_lowercase().replace('_', "");
    let is = |name: &&&str| {
        let lower = name.to_lowercase();
        let is_past = year(name).is_none_or(|year| year <= THIS_YEAR);
        lower.contains(AADT) && is_past && !OTHER.iter().any(|word| lower.contains(word))
    };
    let named: Vec<&&str> = match given {
        Some(given) => names.iter().filter(|name| name.eq_ignore_ascii_case(given)).collect(),
        None => names.iter().filter(is).collect(),
    };
    let latest = named.iter().filter_map(|name| year(name)).max();
    let of_latest: Vec<&&str> = named.into_iter().filter(|name| year(name) == latest).collect();
    let best = given.map_or_else(
        || latest.map_or_else(|| AADT.to_owned(), |year| format!("{AADT}{year}")),
        str::to_owned,
    );
    let exact = |name: &&&&str| ***name == best || (given.is_none() && plain(name) == best);
    let mut exact = of_latest.iter().filter(exact);
    match (&of_latest[..], exact.next(), exact.next()) {
        ([only], ..) | (_, Some(only), None) => Ok((**only).to_owned()),
        (several, ..) => {
            let what =
                if several.is_empty() { "no name is that of" } else { "several names could be" };
            let shown: Vec<_> = names.iter().take(LISTED).map(|name| brief(name)).collect();
            let given = brief(given.unwrap_or("AADT"));
            Err(format!(
                "{what} the count ({given}); the names are {}; give that of the counts as `field`",
                shown.join(", ")
            ))
        }
    }
}

/// Returns a count of vehicles per day if it is one.
///
/// # Arguments
///
/// * `number`: what stands there; not a number if it is none.
/// * `of_year`: the year beside it, if there is one.
///
/// # Errors
///
/// Why it is none; a reason of [`Oddities`](crate::oddities::Oddities).
pub(super) fn usable(number: Option<f64>, of_year: Option<&str>) -> Result<f64, &'static str> {
    if of_year.and_then(year).is_some_and(|year| year > THIS_YEAR) {
        return Err("forecast of a year to come");
    }
    match number {
        None => Err("missing count"),
        Some(number) if !number.is_finite() => Err("count that is no number"),
        Some(number) if number < 0.0 => Err("negative count"),
        // Some agencies write 0 where nothing was counted, and no street has no traffic at all.
        Some(0.0) => Err("count of 0"),
        Some(number) => Ok(number),
    }
}

/// Returns whether a text is a number with a comma or a point.
pub(super) fn is_separated(text: &str) -> bool {
    text.contains([',', '.']) && text.chars().all(|c| c.is_ascii_digit() || "+-.,".contains(c))
}

/// Returns the year in a name, of several the last one.
fn year(name: &str) -> Option<u32> {
    name.split(|c: char| !c.is_ascii_digit())
        .filter_map(|digits| digits.parse().ok())
        .rfind(|year| YEARS.contains(year))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(names: &[&str]) -> Option<String> {
        choose(names, None).ok()
    }

    #[test]
    fn the_only_name_or_else_the_latest_year_is_taken() {
        for (names, expected) in [
            (vec!["ROUTE", "AADT"], Some("AADT")),
            (vec!["aadt", "DOT_AADT"], Some("aadt")),
            (vec!["DOT_AADT", "DOT_AADTYR"], Some("DOT_AADT")),
            (vec!["AADT2019", "AADT2021", "AADT2018"], Some("AADT2021")),
            (vec!["AADT2023_Unrounded", "AADT2024_Unrounded"], Some("AADT2024_Unrounded")),
            (vec!["AADT2024_Unrounded", "AADT_2024"], Some("AADT_2024")),
            (vec!["aadt", "aadt_single_unit", "aadt_combination"], Some("aadt")),
            (vec!["AADT", "AADT2021"], Some("AADT2021")),
            // Trucks and forecasts are no counts of all vehicles.
            (vec!["AADT_TRUCK", "TOTAL_AADT"], Some("TOTAL_AADT")),
            (vec!["AADT_2023", "FUTURE_AADT_2045"], Some("AADT_2023")),
            (vec!["AADT2045", "DOT_AADT"], Some("DOT_AADT")),
            (vec!["AADT_SINGLE_UNIT", "AADT_COMBINATION"], None),
            (vec!["AHEAD_AADT", "BACK_AADT"], None),
            (vec!["AADT", "aadt"], None),
            (vec![], None),
        ] {
            assert_eq!(chosen(&names).as_deref(), expected, "{names:?}");
        }
        assert_eq!(choose(&["aadt", "AADT"], Some("AADT")).unwrap(), "AADT");
        assert_eq!(choose(&["Vol"], Some("vol")).unwrap(), "Vol");
        assert_eq!(
            choose(&["vol", "Vol"], Some("VOL")).unwrap_err(),
            "several names could be the count (VOL); the names are vol, Vol; give that of the counts as `field`"
        );
    }

    #[test]
    fn what_counts_nothing_says_why() {
        assert_eq!(usable(Some(0.5), Some("2021")), Ok(0.5));
        for (number, year, reason) in [
            (None, None, "missing count"),
            (Some(f64::NAN), None, "count that is no number"),
            (Some(-1.0), None, "negative count"),
            (Some(0.0), None, "count of 0"),
            (Some(9.0), Some("2045"), "forecast of a year to come"),
        ] {
            assert_eq!(usable(number, year), Err(reason));
        }
    }
}
