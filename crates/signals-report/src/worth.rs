//! What delay and stops are worth: assumptions of the person who reads the page, each with its default and source.
//!
//! They are in `assumptions.toml` of the results directory, a name and a number per line; whatever is not there has its
//! default. They change no record, so `report` applies them to a finished run.
//!
//! Fuel is that of the difference between two plans for the same vehicles: of delay and of stops. Driving itself is the same.
//!
//! Sources: US Department of Transportation, "Benefit-Cost Analysis Guidance for Discretionary Grant Programs" (2021);
//! TRANSYT-7F's consumption as in the Synchro Studio user guide (0.7329 gal per hour of delay, 0.0000061411 gal times the
//! speed in mph squared per stop, that of the approach on which vehicles stop); US EPA, 8.887 kg of CO2 per gallon of petrol.

use std::path::Path;

use minijinja::{Value, context};

use basics::files::{self, limits};
use basics::suggest::did_you_mean;
use evaluation::store::error::StoreError;

/// Name of the file in a results directory.
pub(super) const FILE: &str = "assumptions.toml";

/// An assumption.
struct Assumption {
    name: &'static str,
    what: &'static str,
    unit: &'static str,
    default: f64,
    most: f64,
    source: &'static str,
}

/// All of them, in the order of [`Worth::values`].
const ALL: [Assumption; 6] = [
    Assumption {
        name: "value_of_time_usd_per_h",
        what: "Value of time",
        unit: "USD per person-hour",
        default: 17.9,
        most: 1000.0,
        source: "US DOT (2021), all purposes, in dollars of 2019",
    },
    Assumption {
        name: "persons_per_vehicle",
        what: "Persons per vehicle",
        unit: "",
        default: 1.67,
        most: 100.0,
        source: "US DOT (2021)",
    },
    Assumption {
        name: "hours_per_year",
        what: "Hours per year like the simulated one",
        unit: "h",
        default: 260.0,
        most: 8784.0,
        source: "one on each working day; where periods have their hours, those count",
    },
    Assumption {
        name: "litres_per_hour_of_delay",
        what: "Fuel while delayed",
        unit: "l per vehicle-hour",
        default: 2.774,
        most: 100.0,
        source: "TRANSYT-7F, as in Synchro",
    },
    Assumption {
        name: "litres_per_stop_at_30_mph",
        what: "Fuel per stop at 30 mph; with the speed squared",
        unit: "l",
        default: 0.0209,
        most: 10.0,
        source: "TRANSYT-7F, as in Synchro",
    },
    Assumption {
        name: "co2_kg_per_litre",
        what: "CO2 per litre of fuel",
        unit: "kg",
        default: 2.348,
        most: 10.0,
        source: "US EPA, petrol",
    },
];

/// Speed at which the fuel of a stop is given, miles per hour.
const STOP_MPH: f64 = 30.0;

/// The assumptions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Worth {
    values: [f64; ALL.len()],
}

/// What a plan costs in a year beyond driving itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Yearly {
    /// Delay, vehicle-hours.
    pub(super) vehicle_hours: f64,
    /// Stops; absent where they were not recorded.
    pub(super) stops: Option<f64>,
    /// Fuel of delay and stops, litres; absent without stops or speeds.
    pub(super) litres: Option<f64>,
    /// CO2 of that, kilograms.
    pub(super) co2_kg: Option<f64>,
    /// Time of those in the vehicles, dollars.
    pub(super) usd: f64,
}

impl Yearly {
    /// Returns the difference to another plan; what one of them lacks is absent.
    pub(super) fn less(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }

    /// Returns the sum with another period.
    pub(super) fn plus(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }

    fn with(self, other: Self, of: fn(f64, f64) -> f64) -> Self {
        let both = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| of(a, b));
        Self {
            vehicle_hours: of(self.vehicle_hours, other.vehicle_hours),
            stops: both(self.stops, other.stops),
            litres: both(self.litres, other.litres),
            co2_kg: both(self.co2_kg, other.co2_kg),
            usd: of(self.usd, other.usd),
        }
    }
}

impl Worth {
    /// Reads the assumptions of a results directory.
    ///
    /// # Errors
    ///
    /// [`StoreError::Setting`] for a file that has something else, with what it has to have.
    pub(super) fn read(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(FILE);
        let text = files::if_present(files::read_text(&path, limits::DOCUMENT))?;
        Self::of(&text.unwrap_or_default()).map_err(|reason| StoreError::Setting { path, reason })
    }

    fn of(text: &str) -> Result<Self, String> {
        let table: toml::Table = toml::from_str(text).map_err(|e| e.message().to_owned())?;
        let mut values = ALL.map(|assumption| assumption.default);
        for (name, value) in &table {
            let names = || ALL.iter().map(|assumption| assumption.name);
            let Some(place) = names().position(|known| known == name) else {
                let all = names().collect::<Vec<_>>().join(", ");
                let meant = did_you_mean(name, names());
                return Err(format!("{name} is no assumption; expected one of {all}{meant}"));
            };
            let most = ALL[place].most;
            let number = value.as_float().or(value.as_integer().map(|n| n as f64));
            values[place] = number
                .filter(|n| (0.0..=most).contains(n))
                .ok_or_else(|| format!("{name} = {value}: expected a number from 0 to {most}"))?;
        }
        Ok(Self { values })
    }

    /// Returns the hours of a year that the simulated time stands for.
    pub(super) fn hours_per_year(&self) -> f64 {
        self.values[2]
    }

    /// Returns what a plan costs in a year.
    ///
    /// # Arguments
    ///
    /// * `vehicles` — in a year.
    /// * `delay_s` — mean per vehicle, seconds.
    /// * `stops` — mean per vehicle.
    /// * `stops_mph2` — the same, each stop times the square of the speed in mph, where it is known.
    pub(super) fn yearly(
        &self,
        vehicles: f64,
        delay_s: f64,
        stops: Option<f64>,
        stops_mph2: Option<f64>,
    ) -> Yearly {
        let [usd_per_h, persons, _, l_per_h, l_per_stop, kg_per_l] = self.values;
        let vehicle_hours = vehicles * delay_s / 3600.0;
        let stops = stops.map(|stops| stops * vehicles);
        let litres = stops_mph2.map(|stops_mph2| {
            vehicle_hours * l_per_h + vehicles * stops_mph2 * l_per_stop / STOP_MPH.powi(2)
        });
        Yearly {
            vehicle_hours,
            stops,
            litres,
            co2_kg: litres.map(|litres| litres * kg_per_l),
            usd: vehicle_hours * persons * usd_per_h,
        }
    }

    /// Returns the assumptions for the page.
    pub(super) fn values(&self) -> Vec<Value> {
        let value = |(assumption, value): (&Assumption, f64)| {
            context! {
                what => assumption.what,
                value => value.to_string(),
                unit => assumption.unit,
                name => assumption.name,
                source => if value == assumption.default { assumption.source } else { "yours" },
            }
        };
        ALL.iter().zip(self.values).map(value).collect()
    }
}

impl Default for Worth {
    fn default() -> Self {
        Self { values: ALL.map(|assumption| assumption.default) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_year_is_worth_what_the_assumptions_say() {
        let worth = Worth::of("value_of_time_usd_per_h = 10\npersons_per_vehicle = 2.0").unwrap();
        let year = worth.yearly(3600.0, 10.0, Some(0.5), Some(0.5 * 60.0 * 60.0));
        assert_eq!((year.vehicle_hours, year.stops, year.usd), (10.0, Some(1800.0), 200.0));
        // 10 h at 2.774 l/h, and 1800 stops at four times the fuel of 30 mph.
        let litres = year.litres.unwrap();
        assert!((litres - (27.74 + 1800.0 * 0.0836)).abs() < 1e-9, "{litres}");
        assert_eq!(worth.yearly(1.0, 1.0, Some(0.5), None).litres, None);
    }

    #[test]
    fn a_wrong_assumption_is_named_with_what_it_has_to_be() {
        let wrong = |text: &str| Worth::of(text).unwrap_err();
        assert!(wrong("value_of_time = 1").contains("is no assumption; expected one of value_of"));
        assert!(wrong("persons_per_vehicle = -1").contains("expected a number from 0 to 100"));
        assert!(wrong("persons_per_vehicle = \"a\"").contains("expected a number"));
        assert!(!wrong("a").is_empty());
    }
}
