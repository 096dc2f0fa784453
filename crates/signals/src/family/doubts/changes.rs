//! What of a table of approaches is simulated otherwise than it stands there.

use super::doubt::{Doubt, at_line};
use crate::family::approaches::{Approach, Intersection, LEAST_PIECE_M};
use crate::family::features::{inflow_vph, six_features, uncapped_vph_per_lane};
use crate::settings::FamilySettings;

/// Returns the values that are changed, with their rows.
pub(super) fn changes(
    intersections: &[Intersection],
    settings: &FamilySettings,
    per_approach: bool,
) -> Vec<Doubt> {
    let approaches = || intersections.iter().flat_map(|i| &i.arms).filter(|a| a.lanes_in > 0);
    let rows = |is: &dyn Fn(&Approach) -> Option<String>| -> Vec<String> {
        approaches().filter_map(|a| is(a).map(|text| at_line(a.line, text))).collect()
    };
    let cap = settings.inflow_cap_vph_per_lane;
    let cut = rows(&|a| {
        let vph = uncapped_vph_per_lane(a, settings);
        (a.counted.is_none() && vph > cap).then(|| format!("{vph:.0} veh/h per lane"))
    });
    let imputed = rows(&|a| {
        a.imputed.then(|| format!("{:.0} veh/day per lane", a.aadt_veh_per_day_per_lane))
    });
    // With U-turns as in the table of Salt Lake City.
    let u_turn = rows(&|a| {
        (a.movements.contains('t') && !a.movements.contains('s')).then(|| a.movements.clone())
    });
    let least = settings.min_inflow_vph;
    let raised = match per_approach {
        true => rows(&|a| {
            let vph = inflow_vph(a, settings);
            (a.counted.is_none() && vph < least).then(|| format!("{vph:.0} veh/h"))
        }),
        false => of_features(intersections, settings, 3, settings.bins.inflow_vph, "veh/h"),
    };
    let mut doubts = vec![
        Doubt::of(
            format!(
                "inflows above family.inflow_cap_vph_per_lane = {cap} are cut to it; set it higher if they are \
                 right"
            ),
            cut,
        ),
        Doubt::of(
            format!("inflows below family.min_inflow_vph = {least} are raised to it"),
            raised,
        ),
        Doubt::of(
            "aadt_veh_per_day_per_lane is empty, and the mean of other approaches stands for it",
            imputed,
        ),
        Doubt::of(
            "movements: t is a U-turn here and nobody goes straight on, because other rows of the table have both s \
             and t; write s where straight on is meant",
            u_turn,
        ),
    ];
    let bays = |a: &Approach| {
        [(a.left_storage_m, "left"), (a.right_storage_m, "right")]
            .into_iter()
            .filter_map(|(m, side)| Some((m?, side)))
            .collect::<Vec<_>>()
    };
    if per_approach {
        let room_m = |a: &Approach| a.length_m * settings.length_scale - LEAST_PIECE_M;
        let whole = rows(&|a| {
            let (m, side) = *bays(a).iter().find(|(m, _)| *m > room_m(a))?;
            Some(format!("{side}, {m} m of {} m", a.length_m))
        });
        doubts.push(Doubt::of(
            "turn lanes whose storage length is nearly that of the approach are as long as the approach",
            whole,
        ));
    } else {
        let lost = rows(&|a| bays(a).first().map(|(m, side)| format!("{side}, {m} m")));
        doubts.push(Doubt::of(
            "six features have no storage lengths; say detail = \"per-approach\" in [family] to simulate them",
            lost,
        ));
    }
    if !per_approach {
        let turns = rows(&|a| a.counted.map(|c| format!("{:.0} veh/h", c.total_vph())));
        doubts.push(Doubt::of(
            "six features keep only the sum of the vehicles that were counted by turn; say detail = \"per-approach\" in \
             [family] to simulate the turns",
            turns,
        ));
        let (lengths, bin_m) = (2, settings.bins.length_m);
        let short = of_features(intersections, settings, lengths, bin_m, "m");
        let about =
            format!("lengths below half of family.bins.length_m = {bin_m} become {bin_m} m");
        doubts.push(Doubt::of(about, short));
    }
    doubts.into_iter().flatten().collect()
}

/// Returns the intersections of which a mean over the arms falls into the bin of 0, so that a minimum takes
/// its place.
fn of_features(
    intersections: &[Intersection],
    settings: &FamilySettings,
    feature: usize,
    bin: f64,
    unit: &str,
) -> Vec<String> {
    let value = |i: &Intersection| six_features(i, settings).to_array()[feature];
    let low = intersections.iter().map(|i| (i, value(i)));
    let low = low.filter(|(_, value)| (value / bin).round_ties_even() < 1.0);
    low.map(|(i, value)| {
        at_line(i.line, format!("intersection {}, {value:.0} {unit} in the mean", i.id))
    })
    .collect()
}
