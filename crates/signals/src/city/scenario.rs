//! The scenario of a city: the text of a file for the table of approaches beside it.

use osm_signals::DrivingSide;
use toml::{Table, Value};

use super::config::CityConfig;
use super::counted::hours;
use super::folder::{self, APPROACHES_FILE};
use super::input::Request;
use crate::settings::InflowSources;
use crate::settings::Scenario;
use crate::settings::check::check;
use evaluation::family::error::FamilyError;
use evaluation::settings::wording::explain;

/// What a scenario file says of its demand.
const DEMAND_NOTE: &str = "\
# Demand is a design hour: hourly_share is the share of the day's traffic in it (1/24 is the mean hour),
# directional_split the share of a two-way street's hour in its peak direction, which is the one within
# 90 degrees of peak_heading_deg (45: north- and eastbound). [family.inflows] says what the inflows of
# approaches.csv rest on, shares of the approaches; pages of results quote it, and it decides nothing.
";

/// Returns the text of the scenario file of a city, for a table of approaches beside it.
///
/// # Arguments
///
/// * `inflows`, `side` — what its comments and settings say of them, once that is known.
///
/// # Errors
///
/// [`FamilyError`] for a setting that does not exist, is out of range, or is decided by the
/// command.
pub(super) fn scenario_text(
    request: &Request,
    config: &CityConfig,
    (inflows, side): (Option<InflowSources>, Option<DrivingSide>),
) -> Result<String, FamilyError> {
    let Request { detail, overrides, .. } = request;
    let (name, extract) = (folder::scenario_name(&request.out), folder::stem(&request.extract));
    let flags: String = overrides.iter().map(|o| format!(" {}", o.flag())).collect();
    let source = request.config.as_ref().map_or("settings".to_owned(), |c| c.display().to_string());
    let source = format!("{source}{flags}");
    let mut table = Table::new();
    table.insert("name".to_owned(), name.as_str().into());
    let title = format!("Signalised intersections of {extract} ((c) OpenStreetMap contributors)");
    table.insert("title".to_owned(), title.into());
    let mut family = Table::new();
    family.insert("approaches".to_owned(), APPROACHES_FILE.into());
    let word = Value::try_from(detail).expect("a detail is a word");
    family.insert("detail".to_owned(), word);
    family.insert("hourly_share".to_owned(), config.hour.hourly_share.into());
    if config.settings.traffic.both_directions {
        let (split, heading) = (config.hour.directional_split, config.hour.peak_heading_deg);
        family.insert("directional_split".to_owned(), split.into());
        family.insert("peak_heading_deg".to_owned(), heading.into());
    }
    if let Some(inflows) = inflows {
        let shares = Value::try_from(inflows).expect("shares are numbers");
        family.insert("inflows".to_owned(), shares);
    }
    if let Some(hours) = hours(&request.periods) {
        family.insert("periods".to_owned(), hours);
    }
    table.insert("family".to_owned(), family.into());
    for (key, value) in &config.scenario {
        match (table.get_mut(key), value) {
            (Some(Value::Table(own)), Value::Table(more)) => own.extend(more.clone()),
            _ => {
                table.insert(key.clone(), value.clone());
            }
        }
    }
    let driving_side = side.unwrap_or_default();
    if driving_side == DrivingSide::Left
        && let Value::Table(network) = table.entry("network").or_insert_with(|| Table::new().into())
    {
        network.entry("driving_side").or_insert_with(|| driving_side.name().into());
    }
    let wrong = |field: &str, value: String, expected: String| FamilyError::Setting {
        file: source.clone(),
        field: field.to_owned(),
        value,
        expected,
    };
    let own = table.clone().try_into::<Scenario>();
    let mut scenario = own.map_err(|e: toml::de::Error| FamilyError::Toml {
        file: format!("{source}, [scenario]"),
        message: explain::<Scenario>(e.message(), ""),
    })?;
    for setting in overrides {
        scenario = setting.apply(&scenario)?;
        setting.put_into(&mut table)?;
    }
    check(&scenario, &source)?;
    let decided = [
        ("name", scenario.name == name, "--out"),
        ("family.detail", scenario.family.detail == *detail, "--detail"),
        ("network.driving_side", scenario.network.driving_side == driving_side, "--driving-side"),
        ("family.points", scenario.family.points.is_none(), "the map"),
        (
            "family.approaches",
            scenario.family.approaches.as_deref() == Some(APPROACHES_FILE),
            "the map",
        ),
    ];
    if let Some((field, _, by)) = decided.into_iter().find(|(_, same, _)| !same) {
        let expected = format!("with --osm {by} decides it; leave it out");
        return Err(wrong(field, "another value".to_owned(), expected));
    }
    let settings = toml::to_string(&table).expect("settings are plain data");
    Ok(format!(
        "# Made from {extract} by `tsc-family build-networks --osm`; what is not here has its \
         default.\n{DEMAND_NOTE}{settings}"
    ))
}
