//! Columns that count the same vehicles or people as others: sums beside their parts, and two of one name.

use std::collections::BTreeSet;

use super::header::{Heading, Holds, says_light};

/// Takes sums of pedestrians to the columns that are not used.
///
/// # Errors
///
/// Columns of which nobody can tell whether one contains the other, and two that count the same.
pub(super) fn settle(
    all: &mut Vec<(usize, Holds)>,
    unused: &mut Vec<String>,
    names: &[String],
) -> Result<(), String> {
    let mut sums: BTreeSet<usize> = Heading::ALL
        .into_iter()
        .flat_map(|heading| sums_of_both_ways(all, names, heading))
        .collect();
    sums.extend(sum_of_all(all, names)?);
    unused.extend(sums.iter().map(|i| names[*i].clone()));
    all.retain(|(i, _)| !sums.contains(i));
    let faults = [unclear(all, names), unclassed(all, names), twice(all, names)];
    faults.into_iter().flatten().next().map_or(Ok(()), Err)
}

/// Returns the columns of people of a direction that stand beside those of both ways across it, clockwise and
/// counterclockwise; or the latter where one of the two is missing.
fn sums_of_both_ways(all: &[(usize, Holds)], names: &[String], heading: Heading) -> Vec<usize> {
    let of = all.iter().filter(|(_, holds)| *holds == Holds::Pedestrians(Some(heading)));
    let (ways, sums): (Vec<usize>, Vec<usize>) =
        of.map(|(i, _)| *i).partition(|i| way(&names[*i]).is_some());
    let has = |wanted: &str| ways.iter().any(|i| way(&names[*i]) == Some(wanted));
    match has("CW") && has("CCW") || sums.is_empty() {
        true => sums,
        false => ways,
    }
}

/// Returns which way people of a column cross.
fn way(name: &str) -> Option<&'static str> {
    let plain: String = name.to_uppercase().chars().filter(char::is_ascii_alphanumeric).collect();
    ["CCW", "CW"].into_iter().find(|way| plain.contains(way))
}

/// Returns the columns of people of any direction where every approach has its own.
fn sum_of_all(all: &[(usize, Holds)], names: &[String]) -> Result<Vec<usize>, String> {
    let is = |wanted: fn(Holds) -> bool| {
        all.iter().filter(move |(_, holds)| wanted(*holds)).map(|(i, _)| *i).collect::<Vec<_>>()
    };
    let of_any = is(|holds| holds == Holds::Pedestrians(None));
    let of_one = is(|holds| matches!(holds, Holds::Pedestrians(Some(_))));
    let (Some(any), Some(one)) = (of_any.first(), of_one.first()) else { return Ok(Vec::new()) };
    let mut vehicles = all.iter().filter_map(|(_, holds)| match holds {
        Holds::Vehicles(heading, _) => Some(*heading),
        _ => None,
    });
    let walks = |heading| all.iter().any(|(_, holds)| *holds == Holds::Pedestrians(Some(heading)));
    match vehicles.all(walks) {
        true => Ok(of_any),
        false => Err(format!(
            "column {} may be the sum of {} and others; remove it if it is, else give every direction a column of its own",
            names[*any], names[*one]
        )),
    }
}

/// Returns what is wrong with heavy vehicles that may be a number or percent.
fn unclear(all: &[(usize, Holds)], names: &[String]) -> Option<String> {
    let (i, _) = all.iter().find(|(_, holds)| matches!(holds, Holds::HeavyUnclear(_)))?;
    let name = &names[*i];
    Some(format!(
        "column {name} may have percentages or numbers of heavy vehicles; call it {name} % or {name} count"
    ))
}

/// Returns what is wrong where trucks stand beside vehicles of the same turn that may contain them.
fn unclassed(all: &[(usize, Holds)], names: &[String]) -> Option<String> {
    all.iter().find_map(|(heavy, holds)| {
        let Holds::HeavyVehicles(heading, towards) = *holds else { return None };
        let is_of_turn = |(i, holds): &&(usize, Holds)| {
            *holds == Holds::Vehicles(heading, towards) && !says_light(&names[*i])
        };
        let (all_of_turn, _) = all.iter().find(is_of_turn)?;
        let (name, heavy) = (&names[*all_of_turn], &names[*heavy]);
        Some(format!(
            "column {name} may contain the vehicles of {heavy}; if it does not, call it {name} Cars, else remove {heavy}"
        ))
    })
}

/// Returns what is wrong where two columns count the same and do not say that it has two exits.
fn twice(all: &[(usize, Holds)], names: &[String]) -> Option<String> {
    let is_second = |name: &str| {
        let name = name.to_uppercase();
        name.ends_with('2') || ["HARD", "BEAR"].iter().any(|word| name.contains(word))
    };
    all.iter().enumerate().find_map(|(k, (i, holds))| {
        let same = |(j, other): &&(usize, Holds)| {
            let is_same = match (holds, other) {
                (
                    Holds::HeavyPercent(one) | Holds::HeavyCount(one),
                    Holds::HeavyPercent(other) | Holds::HeavyCount(other),
                ) => one == other,
                (Holds::Vehicles(..) | Holds::Total(_), _) => holds == other,
                (Holds::Pedestrians(_), _) => holds == other && way(&names[*i]) == way(&names[*j]),
                _ => false,
            };
            is_same && !is_second(&names[*i]) && !is_second(&names[*j])
        };
        let (j, _) = all[..k].iter().find(same)?;
        let (one, other) = (&names[*j], &names[*i]);
        Some(format!("columns {one} and {other} count the same; remove one, or add their numbers"))
    })
}
