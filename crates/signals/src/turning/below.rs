//! Names of columns whose directions stand in a line above their turns.

use std::ops::Range;

use sheet::uneven::Line;

use super::ENOUGH;
use super::header::{Holds, holds};

/// Lines above the turns among which the directions are: names of streets may stand between.
const MOST_BETWEEN: usize = 3;

/// Name of a column with the sum of all approaches; `Int` alone would be an intersection.
const SUM: &str = "Int. Total";

/// Returns the names of the columns of a line that has turns only, such as `Left, Thru, Right`, each with the direction
/// above it; `None` for another line.
///
/// A direction stands over the first of its columns. It may stand over another one if all directions have the same columns.
///
/// # Errors
///
/// Directions of which nobody can tell which columns are theirs.
pub(super) fn below_directions(lines: &[Line], at: usize) -> Option<Result<Vec<String>, String>> {
    let names: Vec<&str> = lines[at].fields().collect();
    if names.iter().filter(|name| is_turn(name)).count() < ENOUGH {
        return None;
    }
    let above = lines[..at].iter().rev().take(MOST_BETWEEN);
    let above =
        above.into_iter().find(|l| l.fields().filter(|field| is_heading(field)).count() >= 2)?;
    let headings: Vec<usize> =
        (0..above.fields().count()).filter(|i| is_heading(above.text(*i))).collect();
    let is_repeated = |name: &str| names.iter().filter(|other| **other == name).count() > 1;
    let before = names.iter().take(headings[0]);
    let mut before = before.enumerate().filter(|(_, name)| !name.is_empty());
    if let Some((early, name)) = before.find(|(_, name)| is_turn(name) || is_repeated(name)) {
        let Some(groups) = groups(&names, early, &headings) else {
            return Some(Err(format!(
                "column {} ({name}) has no direction above it in line {}; write each direction over the first of its \
                 columns",
                early + 1,
                above.number
            )));
        };
        let heading_of = |i: usize| {
            let group = groups.iter().position(|group| group.contains(&i));
            group.map_or("", |group| above.text(headings[group]))
        };
        let named = names.iter().enumerate().map(|(i, name)| named(heading_of(i), name));
        return Some(Ok(named.collect()));
    }
    let mut heading = "";
    let named = names.iter().enumerate().map(|(i, name)| {
        let over = above.text(i);
        if !over.is_empty() {
            heading = if is_heading(over) { over } else { "" };
        }
        named(heading, name)
    });
    Some(Ok(named.collect()))
}

/// Returns the name of a column with its direction.
fn named(heading: &str, name: &str) -> String {
    match (heading, name) {
        ("", _) | (_, "") => name.to_owned(),
        (_, name) if name.eq_ignore_ascii_case("int") => SUM.to_owned(),
        _ => format!("{heading} {name}"),
    }
}

/// Returns the columns of each direction where all have the same ones, which begin anew when a name comes again; `None`
/// where they do not.
///
/// # Arguments
///
/// * `early` — the first column of the first direction.
/// * `headings` — over which column each direction stands.
fn groups(names: &[&str], early: usize, headings: &[usize]) -> Option<Vec<Range<usize>>> {
    let mut starts = vec![early];
    for (i, name) in names.iter().enumerate().skip(early) {
        let start = starts[starts.len() - 1];
        if !name.is_empty() && names[start..i].contains(name) {
            starts.push(i);
        }
    }
    let size = starts.get(1)? - early;
    let ends = starts.iter().skip(1).copied().chain([names.len()]);
    let groups = starts.iter().zip(ends).map(|(start, end)| *start..end);
    let groups: Vec<Range<usize>> = groups.collect();
    let first = &names[early..early + size];
    let is_same = |group: &Range<usize>| names[group.start..].starts_with(first);
    // After the last direction may be a sum.
    let (last, others) = groups.split_last()?;
    let fits = others.iter().all(|group| is_same(group) && group.len() == size) && is_same(last);
    let is_in = groups.iter().zip(headings).all(|(group, heading)| group.contains(heading));
    (fits && is_in && groups.len() == headings.len()).then_some(groups)
}

/// Any direction makes a movement of a turn.
fn is_turn(name: &str) -> bool {
    !name.is_empty() && matches!(holds(&format!("NB{name}")), Some(Holds::Vehicles(..)))
}

fn is_heading(name: &str) -> bool {
    name.len() > 1 && matches!(holds(&format!("{name}L")), Some(Holds::Vehicles(..)))
}

#[cfg(test)]
mod tests {
    use sheet::uneven;

    use super::*;

    fn below(text: &str) -> Result<String, String> {
        let lines = uneven::lines(text.as_bytes()).unwrap();
        below_directions(&lines, lines.len() - 1).unwrap().map(|names| names.join(","))
    }

    #[test]
    fn directions_may_stand_over_the_middle_of_equal_groups() {
        let equal = below(",,NB,,,SB,,\nTime,Right,Thru,Left,Right,Thru,Left,Int\n");
        let expected = "Time,NB Right,NB Thru,NB Left,SB Right,SB Thru,SB Left,Int. Total";
        assert_eq!(equal.as_deref(), Ok(expected));
        let unequal = below(",,NB,,,SB\nTime,Thru,Left,Left,Thru,Right\n").unwrap_err();
        assert_eq!(
            unequal,
            "column 2 (Thru) has no direction above it in line 1; write each direction over the first of its columns"
        );
    }

    #[test]
    fn directions_over_their_first_columns_may_have_different_ones() {
        let names = below(",NB,,SB,,EB\nTime,Thru,Right,Left,Thru,Left,App,Int\n");
        let expected = "Time,NB Thru,NB Right,SB Left,SB Thru,EB Left,EB App,Int. Total";
        assert_eq!(names.as_deref(), Ok(expected));
    }
}
