//! Where on Earth traffic keeps to the left.
//!
//! Borders are those of OpenStreetMap as the crate `country-boundaries` carries them (ODbL), with
//! territorial waters. The sea beyond belongs to no country and says nothing.
//!
//! Source of the list: <https://en.wikipedia.org/wiki/Left-_and_right-hand_traffic>, as of 2024.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use country_boundaries::{BOUNDARIES_ODBL_60X30, CountryBoundaries, LatLon};
use serde::Serialize;

use crate::driving_side::DrivingSide;
use crate::extract::Place;

/// ISO 3166-1 codes of the countries and territories where traffic keeps to the left.
const LEFT: [&str; 76] = [
    "AG", "AI", "AU", "BB", "BD", "BM", "BN", "BS", "BT", "BW", "CC", "CK", "CX", "CY", "DM", "FJ",
    "FK", "GB", "GD", "GG", "GS", "GY", "HK", "ID", "IE", "IM", "IN", "JE", "JM", "JP", "KE", "KI",
    "KN", "KY", "LC", "LK", "LS", "MO", "MS", "MT", "MU", "MV", "MW", "MY", "MZ", "NA", "NF", "NP",
    "NR", "NU", "NZ", "PG", "PK", "PN", "SB", "SC", "SG", "SH", "SR", "SZ", "TC", "TH", "TK", "TL",
    "TO", "TT", "TV", "TZ", "UG", "VC", "VG", "VI", "WS", "ZA", "ZM", "ZW",
];

/// ISO 3166-1 codes of the countries and territories whose signs have miles per hour.
///
/// Source: <https://en.wikipedia.org/wiki/Miles_per_hour>, usage on signs, as of 2024.
const MILES: [&str; 27] = [
    "AG", "AI", "AS", "BS", "BZ", "DM", "FK", "GB", "GD", "GG", "GU", "IM", "JE", "KN", "KY", "LC",
    "LR", "MP", "MS", "PR", "SH", "TC", "US", "VC", "VG", "VI", "WS",
];

/// Returns whether signs have miles per hour in a country, by its ISO 3166-1 code.
pub fn signs_in_miles(code: &str) -> bool {
    MILES.contains(&code)
}

/// How many places lie in a country, and on which side traffic keeps there.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Country {
    /// ISO 3166 code.
    pub code: String,
    /// The side there.
    pub driving_side: DrivingSide,
    /// Places.
    pub places: usize,
}

/// Returns the countries of some places, the one with most places first; places at sea are left out.
pub fn countries(places: impl Iterator<Item = Place>) -> Vec<Country> {
    let mut found: BTreeMap<(String, DrivingSide), usize> = BTreeMap::new();
    for place in places {
        if let Some(country) = country(place) {
            *found.entry(country).or_default() += 1;
        }
    }
    let country = |((code, driving_side), places)| Country { code, driving_side, places };
    let mut countries: Vec<Country> = found.into_iter().map(country).collect();
    countries.sort_by(|a, b| b.places.cmp(&a.places).then_with(|| a.code.cmp(&b.code)));
    countries
}

/// Returns the code of the country of a place and the side there.
fn country(place: Place) -> Option<(String, DrivingSide)> {
    static BOUNDARIES: OnceLock<CountryBoundaries> = OnceLock::new();
    let boundaries = BOUNDARIES.get_or_init(|| {
        CountryBoundaries::from_reader(BOUNDARIES_ODBL_60X30).expect("the crate reads its own data")
    });
    let position = LatLon::new(place.latitude(), place.longitude()).ok()?;
    // The smallest region comes first: a state before its country, and a territory with a code of its
    // own, such as Hong Kong (HK) or the Virgin Islands (VI), before the country that it belongs to.
    let region = *boundaries.ids(position).first()?;
    let country = region.split_once('-').map_or(region, |(country, _)| country);
    let side = if LEFT.contains(&country) { DrivingSide::Left } else { DrivingSide::Right };
    Some((country.to_owned(), side))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(latitude: f64, longitude: f64) -> Option<(String, DrivingSide)> {
        country(Place::from_degrees(latitude, longitude).unwrap())
    }

    #[test]
    fn codes_are_sorted_so_that_none_is_there_twice() {
        assert!(LEFT.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn cities_are_on_their_side_of_the_border() {
        for (name, latitude, longitude, left) in [
            ("London", 51.51, -0.13, true),
            ("Dover", 51.128, 1.315, true),
            ("Calais", 50.95, 1.86, false),
            ("Belfast", 54.60, -5.93, true),
            ("Dublin", 53.35, -6.26, true),
            ("Saint Helier", 49.186, -2.106, true),
            ("Cherbourg", 49.64, -1.62, false),
            ("Gibraltar", 36.14, -5.353, false),
            ("Valletta", 35.899, 14.514, true),
            ("Nicosia", 35.17, 33.36, true),
            ("Sydney", -33.87, 151.21, true),
            ("Auckland", -36.85, 174.76, true),
            ("Tokyo", 35.68, 139.76, true),
            ("Tsushima", 34.2, 129.29, true),
            ("Busan", 35.18, 129.08, false),
            ("Hong Kong", 22.319, 114.169, true),
            ("Shenzhen", 22.543, 114.058, false),
            ("Macau", 22.199, 113.544, true),
            ("Zhuhai", 22.27, 113.57, false),
            ("Bangkok", 13.756, 100.502, true),
            ("Vientiane", 17.967, 102.6, false),
            ("Poipet", 13.656, 102.567, false),
            ("Tachileik", 20.453, 99.884, false),
            ("Kuala Lumpur", 3.139, 101.687, true),
            ("Singapore", 1.352, 103.82, true),
            ("Jakarta", -6.2, 106.82, true),
            ("Dili", -8.556, 125.56, true),
            ("Port Moresby", -9.44, 147.18, true),
            ("Delhi", 28.61, 77.21, true),
            ("Lahore", 31.55, 74.34, true),
            ("Kabul", 34.53, 69.17, false),
            ("Dhaka", 23.81, 90.41, true),
            ("Mandalay", 21.96, 96.09, false),
            ("Colombo", 6.93, 79.85, true),
            ("Kathmandu", 27.72, 85.32, true),
            ("Male", 4.175, 73.509, true),
            ("Nairobi", -1.286, 36.817, true),
            ("Addis Ababa", 9.03, 38.74, false),
            ("Kampala", 0.347, 32.58, true),
            ("Kigali", -1.944, 30.06, false),
            ("Goma", -1.679, 29.222, false),
            ("Lusaka", -15.39, 28.32, true),
            ("Lubumbashi", -11.66, 27.48, false),
            ("Maputo", -25.97, 32.57, true),
            ("Windhoek", -22.56, 17.08, true),
            ("Luanda", -8.84, 13.23, false),
            ("Cape Town", -33.92, 18.42, true),
            ("Maseru", -29.31, 27.48, true),
            ("Antananarivo", -18.88, 47.51, false),
            ("Port Louis", -20.16, 57.5, true),
            ("Saint-Denis", -20.88, 55.45, false),
            ("Georgetown", 6.8, -58.16, true),
            ("Paramaribo", 5.85, -55.2, true),
            ("Boa Vista", 2.82, -60.67, false),
            ("Cayenne", 4.92, -52.31, false),
            ("Kingston", 18.0, -76.79, true),
            ("Nassau", 25.06, -77.35, true),
            ("Miami", 25.76, -80.19, false),
            ("Bridgetown", 13.1, -59.61, true),
            ("Port of Spain", 10.66, -61.51, true),
            ("Charlotte Amalie", 18.342, -64.93, true),
            ("Road Town", 18.43, -64.62, true),
            ("San Juan", 18.46, -66.1, false),
            ("Stanley", -51.69, -57.86, true),
            ("Suva", -18.14, 178.44, true),
            ("Apia", -13.83, -171.77, true),
            ("Pago Pago", -14.28, -170.7, false),
            ("Noumea", -22.27, 166.45, false),
            ("Salt Lake City", 40.76, -111.89, false),
            ("Berlin", 52.52, 13.4, false),
            ("Manila", 14.6, 120.98, false),
            ("Bernina", 46.41, 10.02, false),
        ] {
            let found = side(latitude, longitude);
            let expected = if left { DrivingSide::Left } else { DrivingSide::Right };
            assert_eq!(found.as_ref().map(|f| f.1), Some(expected), "{name}: {found:?}");
        }
    }

    #[test]
    fn the_high_sea_says_nothing() {
        assert_eq!(side(30.0, -40.0), None);
        assert_eq!(countries(Place::from_degrees(30.0, -40.0).into_iter()), []);
    }

    #[test]
    fn countries_come_by_their_number_of_places() {
        let places = [(51.128, 1.315), (50.95, 1.86), (50.94, 1.85)];
        let places = places.into_iter().filter_map(|(lat, lon)| Place::from_degrees(lat, lon));
        let codes: Vec<_> = countries(places).into_iter().map(|c| (c.code, c.places)).collect();
        assert_eq!(codes, [("FR".to_owned(), 2), ("GB".to_owned(), 1)]);
    }
}
