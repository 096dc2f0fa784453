//! Turn restrictions: what a relation `type=restriction` forbids or prescribes to cars.
//!
//! Choices where readers differ:
//! - `restriction:motorcar` and `restriction:motor_vehicle` go before `restriction`.
//! - What holds at certain times only keeps these times: which hour is simulated is not known here.
//! - `no_u_turn` is left out: signals here are modelled without U-turns.
//!
//! Source: <https://wiki.openstreetmap.org/wiki/Relation:restriction>.

use crate::extract::{Hours, Restriction, Via};
use crate::oddities::Oddities;
use crate::tags::{Tags, tag};

/// Most members of a restriction that are believed; real ones have three to ten.
const MAX_MEMBERS: usize = 100;

/// Keys of what a restriction says about cars, the most specific first.
const KEYS: [&str; 3] = ["restriction:motorcar", "restriction:motor_vehicle", "restriction"];

/// Keys that limited a restriction to a time before `restriction:conditional` was invented.
const TIMES: [&str; 4] = ["day_on", "day_off", "hour_on", "hour_off"];

/// End of a key whose value holds under conditions only.
const CONDITIONAL: &str = ":conditional";

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Kind {
    #[default]
    Node,
    Way,
    Relation,
}

/// A member of a relation: what it is, its id, and its part in the relation.
pub(super) type Member<'a> = (Kind, i64, &'a str);

/// What cannot be used is counted.
pub(super) fn restrictions(
    relation: i64,
    tags: &Tags<'_>,
    members: &[Member<'_>],
    oddities: &mut Oddities,
) -> Vec<Restriction> {
    let mut found = Vec::new();
    if tag(tags, "type") != Some("restriction") {
        return found;
    }
    let mut add = |reason: &'static str| oddities.add(reason, || format!("relation {relation}"));
    match clauses(tags) {
        Err(reason) => add(reason),
        Ok(clauses) => {
            for clause in clauses {
                match clause.and_then(|(kind, when)| between(kind, when.as_ref(), members)) {
                    Ok(more) => found.extend(more),
                    Err(reason) => add(reason),
                }
            }
        }
    }
    found
}

/// A kind, such as `no_left_turn`, and the times at which it holds, if it does not always; or why it cannot be used.
type Clause<'a> = Result<(&'a str, Option<Hours>), &'static str>;

/// What is said of a restriction that is for some vehicles only.
const NOT_FOR_CARS: &str = "turn restriction that is not for cars";

/// What is said of a restriction whose times are not in the syntax of `opening_hours`.
const OTHER_TIMES: &str = "turn restriction at times that are not understood";

fn clauses<'a>(tags: &Tags<'a>) -> Result<Vec<Clause<'a>>, &'static str> {
    let except = tag(tags, "except").unwrap_or_default();
    if except.split(';').any(|v| matches!(v.trim(), "motorcar" | "motor_vehicle")) {
        return Err(NOT_FOR_CARS);
    }
    if let Some(value) = KEYS.iter().find_map(|key| tag(tags, key)) {
        let when = match TIMES.iter().any(|key| tag(tags, key).is_some()) {
            true => Some(days_and_hours(tags).ok_or(OTHER_TIMES)?),
            false => None,
        };
        return Ok(kind(value)?.map(|kind| Ok((kind, when))).into_iter().collect());
    }
    let conditional = KEYS.iter().find_map(|key| {
        let is = |k: &str| k.strip_suffix(CONDITIONAL) == Some(key);
        tags.iter().find(|(k, _)| is(k)).map(|(_, value)| *value)
    });
    match conditional {
        Some(value) => Ok(conditions(value).collect()),
        None if tags.iter().any(|(key, _)| key.starts_with("restriction:")) => Err(NOT_FOR_CARS),
        None => Err("turn restriction of no kind"),
    }
}

/// Returns the clauses of a value such as `no_left_turn @ (Mo-Fr 07:00-09:00); no_u_turn @ 24/7`.
fn conditions(value: &str) -> impl Iterator<Item = Clause<'_>> {
    let mut open = 0_i32;
    let parts = value.split(move |c| {
        open += i32::from(c == '(') - i32::from(c == ')');
        c == ';' && open == 0
    });
    parts.filter(|part| !part.trim().is_empty()).filter_map(|part| {
        let Some((value, times)) = part.split_once('@') else { return Some(Err(OTHER_TIMES)) };
        let times = times.trim();
        let inner = times.strip_prefix('(').and_then(|t| t.strip_suffix(')')).unwrap_or(times);
        match (kind(value.trim()), Hours::parse(inner)) {
            (Ok(None), _) => None,
            (Ok(Some(kind)), Some(hours)) => Some(Ok((kind, Some(hours)))),
            (Ok(Some(_)), None) => Some(Err(OTHER_TIMES)),
            (Err(reason), _) => Some(Err(reason)),
        }
    })
}

fn days_and_hours(tags: &Tags<'_>) -> Option<Hours> {
    let usual = ["Mo", "Su", "00:00", "24:00"];
    let [first, last, begin, end] =
        std::array::from_fn(|i| tag(tags, TIMES[i]).unwrap_or(usual[i]).trim());
    Hours::parse(&format!("{first}-{last} {begin}-{end}"))
}

/// Returns the kind that a value names, such as `no_left_turn`; `Ok(None)` if it is none that matters here.
fn kind(value: &str) -> Result<Option<&str>, &'static str> {
    let mut kinds = value.split(';').map(str::trim).filter(|kind| *kind != "no_u_turn");
    match kinds.next() {
        None => Ok(None),
        Some(kind) if kind.starts_with("no_") || kind.starts_with("only_") => Ok(Some(kind)),
        Some(_) => Err("turn restriction of an unknown kind"),
    }
}

fn between(
    kind: &str,
    when: Option<&Hours>,
    members: &[Member<'_>],
) -> Result<Vec<Restriction>, &'static str> {
    const UNCLEAR: &str = "turn restriction with more members than it can have";
    if members.len() > MAX_MEMBERS {
        return Err(UNCLEAR);
    }
    let ids = |role: &str, kind: Kind| -> Vec<i64> {
        members.iter().filter(|m| (m.0, m.2) == (kind, role)).map(|m| m.1).collect()
    };
    let (from, to) = (ids("from", Kind::Way), ids("to", Kind::Way));
    let via = match (&*ids("via", Kind::Node), ids("via", Kind::Way)) {
        ([node], ways) if ways.is_empty() => Some(Via::Node(*node)),
        ([], ways) if !ways.is_empty() => Some(Via::Ways(ways)),
        ([], _) => None,
        _ => return Err(UNCLEAR),
    };
    let via = via.filter(|_| !from.is_empty() && !to.is_empty());
    let via = via.ok_or("turn restriction without one of from, via and to")?;
    let several = (from.len() > 1, to.len() > 1);
    let fine = match kind {
        "no_entry" => !several.1,
        "no_exit" => !several.0,
        _ => several == (false, false),
    };
    if !fine {
        return Err(UNCLEAR);
    }
    let only = kind.starts_with("only_");
    let pairs = from.iter().flat_map(|from| to.iter().map(|to| (*from, *to)));
    let restriction =
        |(from, to)| Restriction { from, via: via.clone(), to, only, when: when.cloned() };
    Ok(pairs.map(restriction).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMBERS: [Member<'static>; 3] = [way(1, "from"), node(2, "via"), way(3, "to")];

    const fn way(id: i64, role: &'static str) -> Member<'static> {
        (Kind::Way, id, role)
    }

    const fn node(id: i64, role: &'static str) -> Member<'static> {
        (Kind::Node, id, role)
    }

    fn read(tags: &Tags<'_>, members: &[Member<'_>]) -> (Vec<Restriction>, Option<&'static str>) {
        let mut oddities = Oddities::default();
        let tags = [&[("type", "restriction")], tags].concat();
        let found = restrictions(9, &tags, members, &mut oddities);
        let reason = oddities.iter().next().map(|(reason, _)| reason);
        (found, reason)
    }

    fn one(only: bool) -> Vec<Restriction> {
        vec![Restriction { from: 1, via: Via::Node(2), to: 3, only, when: None }]
    }

    #[test]
    fn a_restriction_forbids_or_prescribes_one_turn() {
        assert_eq!(read(&[("restriction", "no_left_turn")], &MEMBERS), (one(false), None));
        assert_eq!(read(&[("restriction", "only_straight_on")], &MEMBERS), (one(true), None));
        assert_eq!(
            read(&[("restriction", "no_u_turn; no_left_turn")], &MEMBERS),
            (one(false), None)
        );
        let cars = [("restriction", "no_left_turn"), ("restriction:motorcar", "only_left_turn")];
        assert_eq!(read(&cars, &MEMBERS), (one(true), None));
    }

    #[test]
    fn u_turns_are_dropped_silently() {
        assert_eq!(read(&[("restriction", "no_u_turn")], &MEMBERS), (vec![], None));
    }

    #[test]
    fn what_is_not_for_cars_is_counted() {
        let not_cars = "turn restriction that is not for cars";
        let times = "turn restriction at times that are not understood";
        for (tags, reason) in [
            (vec![("restriction:hgv", "no_left_turn")], not_cars),
            (vec![("restriction:hgv:conditional", "no_left_turn @ (07:00-09:00)")], not_cars),
            (vec![("restriction", "no_left_turn"), ("except", "bus; motorcar")], not_cars),
            (vec![("restriction:conditional", "no_left_turn @ (weight>3.5)")], times),
            (vec![("restriction:conditional", "no_left_turn")], times),
            (vec![("restriction", "no_left_turn"), ("hour_on", "school")], times),
            (vec![("name", "x")], "turn restriction of no kind"),
            (vec![("restriction", "maybe")], "turn restriction of an unknown kind"),
        ] {
            assert_eq!(read(&tags, &MEMBERS), (vec![], Some(reason)), "{tags:?}");
        }
        let bus = [("restriction", "no_left_turn"), ("except", "bus")];
        assert_eq!(read(&bus, &MEMBERS), (one(false), None));
    }

    #[test]
    fn times_stay_with_the_restriction() {
        let day = [
            ("day_on", "Monday"),
            ("day_off", "Friday"),
            ("hour_on", "07:00"),
            ("hour_off", "19:00"),
        ];
        let old = [&[("restriction", "no_left_turn")], &day[..]].concat();
        let both = "no_left_turn @ (Mo-Fr 07:00-09:00; PH off); only_straight_on @ (16:00-18:00); no_u_turn @ 24/7";
        let (found, reason) = read(&old, &MEMBERS);
        assert_eq!((found[0].holds(8.0), found[0].holds(20.0), reason), (true, false, None));
        let (found, reason) = read(&[("restriction:conditional", both)], &MEMBERS);
        let holds = |time| found.iter().map(|r| (r.only, r.holds(time))).collect::<Vec<_>>();
        assert_eq!(holds(8.0), [(false, true), (true, false)]);
        assert_eq!((holds(16.0), reason), (vec![(false, false), (true, true)], None));
    }

    #[test]
    fn members_that_are_missing_or_too_many_are_counted() {
        let no_left = [("restriction", "no_left_turn")];
        let incomplete = Some("turn restriction without one of from, via and to");
        for missing in 0..3 {
            let mut members = MEMBERS.to_vec();
            members.remove(missing);
            assert_eq!(read(&no_left, &members), (vec![], incomplete), "{missing}");
        }
        let unclear = Some("turn restriction with more members than it can have");
        for surplus in [way(4, "from"), way(4, "to"), node(4, "via"), way(4, "via")] {
            let members = [&MEMBERS[..], &[surplus]].concat();
            assert_eq!(read(&no_left, &members), (vec![], unclear), "{surplus:?}");
        }
        assert_eq!(read(&no_left, &MEMBERS.repeat(40)), (vec![], unclear));
    }

    #[test]
    fn several_ways_of_no_entry_and_no_exit_give_a_restriction_each() {
        let members = [&MEMBERS[..], &[way(4, "from")]].concat();
        let (found, reason) = read(&[("restriction", "no_entry")], &members);
        assert_eq!(found.iter().map(|r| (r.from, r.to)).collect::<Vec<_>>(), [(1, 3), (4, 3)]);
        assert_eq!(reason, None);
        let members = [&MEMBERS[..], &[way(4, "to")]].concat();
        let (found, _) = read(&[("restriction", "no_exit")], &members);
        assert_eq!(found.iter().map(|r| (r.from, r.to)).collect::<Vec<_>>(), [(1, 3), (1, 4)]);
    }

    #[test]
    fn a_restriction_leads_through_ways_too() {
        let members = [way(1, "from"), way(5, "via"), way(6, "via"), way(3, "to")];
        let (found, _) = read(&[("restriction", "no_left_turn")], &members);
        assert_eq!(found[0].via, Via::Ways(vec![5, 6]));
    }
}
