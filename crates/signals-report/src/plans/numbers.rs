//! Numbers of phases as the existing plan of an intersection has them.
//!
//! The methods with two rings give 2 and 6 to the street with most lanes; the cabinet may have them otherwise. Only whole
//! streets, and the two directions of a street, change places, so that the order of phases and who is green beside whom stay
//! what they were. Where that does not make the numbers equal, a note says which phase is which.

use signals::existing::{ExistingPlan, PlanPhase};

/// Numbers of phases in two rings around two barriers.
const USUAL: std::ops::RangeInclusive<u32> = 1..=8;

/// What tells the two streets apart in a number less 1.
const STREET: u32 = 2;

/// What tells the two rings apart in a number less 1.
const RING: u32 = 4;

/// What changes places.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Exchange {
    streets: bool,
    /// Per street, whether its directions do.
    directions: [bool; 2],
}

impl Exchange {
    /// Returns all of them, that of nothing first.
    fn all() -> impl Iterator<Item = Self> {
        let is = |bits: u32, bit: u32| bits & bit != 0;
        (0..8)
            .map(move |bits| Self { streets: is(bits, 1), directions: [is(bits, 2), is(bits, 4)] })
    }

    /// Whether a phase gets another ring.
    fn turns(self, number: u32) -> bool {
        self.directions[usize::from((number - 1) & STREET != 0)]
    }

    /// Returns the new number of a phase.
    fn number(self, number: u32) -> u32 {
        let street = if self.streets { STREET } else { 0 };
        let ring = if self.turns(number) { RING } else { 0 };
        ((number - 1) ^ street ^ ring) + 1
    }

    /// Whether the phases of a plan get the numbers that those with their movements have today.
    fn fits(self, plan: &ExistingPlan, today: &ExistingPlan) -> bool {
        plan.phases.iter().all(|phase| {
            let number = self.number(phase.number);
            let of_number = today.phases.iter().find(|other| other.number == number);
            let is_left = number % 2 == 1;
            match of_number {
                Some(other) => serves(other, phase),
                // Today its left turns may have no phase of their own, but none of another number.
                None => {
                    is_left && !today.phases.iter().any(|o| o.number % 2 == 1 && serves(o, phase))
                }
            }
        })
    }

    /// Gives the phases of a plan their new numbers.
    fn renumber(self, plan: &mut ExistingPlan) {
        for phase in &mut plan.phases {
            if self.turns(phase.number) {
                phase.ring = 3 - phase.ring;
            }
            phase.number = self.number(phase.number);
        }
        plan.reference.iter_mut().for_each(|number| *number = self.number(*number));
        plan.reference.sort_unstable();
        let first = |barrier: u32| {
            let own = plan.phases.iter().filter(|phase| phase.barrier == barrier);
            own.map(|phase| phase.number).min()
        };
        let is_behind = first(1).zip(first(2)).is_some_and(|(first, second)| first > second);
        if self.streets && is_behind {
            // Two sides take turns: which one is the first makes no difference.
            plan.phases.iter_mut().for_each(|phase| phase.barrier = 3 - phase.barrier);
        }
        plan.phases.sort_by_key(|phase| (phase.barrier, phase.ring, phase.position));
    }
}

/// Gives the phases of a plan in two rings the numbers that they have in the existing plan, if that is possible, and returns
/// what to say of it.
pub(super) fn as_today(plan: &mut ExistingPlan, today: &ExistingPlan) -> Option<String> {
    let is_usual = |phase: &PlanPhase| {
        USUAL.contains(&phase.number)
            && (1..=2).contains(&phase.ring)
            && (1..=2).contains(&phase.barrier)
    };
    let fitting = match plan.phases.iter().all(is_usual) {
        true => Exchange::all().find(|exchange| exchange.fits(plan, today)),
        false => None,
    };
    let Some(exchange) = fitting else {
        return said(plan, today).map(|pairs| {
            format!("The existing plan numbers phases otherwise (here = there): {pairs}.")
        });
    };
    let moved = |phase: &PlanPhase| {
        let number = exchange.number(phase.number);
        (number != phase.number).then_some((number, phase.number))
    };
    let mut pairs: Vec<(u32, u32)> = plan.phases.iter().filter_map(moved).collect();
    if pairs.is_empty() {
        return None;
    }
    pairs.sort_unstable();
    exchange.renumber(plan);
    Some(format!(
        "Phases have the numbers of the existing plan. The records and events of the run, and plans.csv, have other numbers (here = there): {}.",
        list(&pairs)
    ))
}

/// Returns which phases have another number today; `None` where none of them does.
fn said(plan: &ExistingPlan, today: &ExistingPlan) -> Option<String> {
    let mut pairs = Vec::new();
    for phase in &plan.phases {
        let own: Vec<&PlanPhase> = today.phases.iter().filter(|o| serves(o, phase)).collect();
        if own.iter().any(|other| other.number == phase.number) {
            continue;
        }
        // Those in which it yields count where it has the right of way in none.
        let goes_first =
            |other: &PlanPhase| phase.movements.iter().any(|name| other.movements.contains(name));
        let is_any_first = own.iter().any(|other| goes_first(other));
        let counted = own.iter().filter(|other| !is_any_first || goes_first(other));
        pairs.extend(counted.map(|other| (phase.number, other.number)));
    }
    pairs.sort_unstable();
    (!pairs.is_empty()).then(|| list(&pairs))
}

/// Says pairs of numbers.
fn list(pairs: &[(u32, u32)]) -> String {
    let said: Vec<String> = pairs.iter().map(|(here, there)| format!("{here} = {there}")).collect();
    said.join(", ")
}

/// Whether a phase of the existing plan serves what a phase is for: its through movements if it has some.
fn serves(other: &PlanPhase, phase: &PlanPhase) -> bool {
    let ahead: Vec<&String> = phase.movements.iter().filter(|name| name.contains('T')).collect();
    if ahead.is_empty() {
        let has = |name: &String| other.all_movements().any(|own| own == name);
        return !phase.movements.is_empty() && phase.movements.iter().all(has);
    }
    ahead.into_iter().all(|name| other.movements.contains(name))
}

#[cfg(test)]
mod tests {
    use signals::existing::{Control, Recall};

    use super::*;

    /// Number, barrier, ring, position and movements of each phase; of those in small letters it yields.
    fn plan(phases: &[(u32, [u32; 3], &str)]) -> ExistingPlan {
        let phase = |(number, [barrier, ring, position], names): &(u32, [u32; 3], &str)| {
            let of = |is_small: bool| {
                let is = |name: &&str| name.chars().any(char::is_lowercase) == is_small;
                names.split_whitespace().filter(is).map(str::to_uppercase).collect()
            };
            PlanPhase {
                number: *number,
                ring: *ring,
                barrier: *barrier,
                position: *position,
                movements: of(false),
                yielding: of(true),
                min_green_s: 5.0,
                max_green_s: 20.0,
                passage_s: 3.0,
                yellow_s: 4.0,
                all_red_s: 1.0,
                walk_s: None,
                recall: Recall::None,
                dual_entry: true,
                inhibit_max: false,
            }
        };
        ExistingPlan::new(Control::Actuated, phases.iter().map(phase).collect())
    }

    /// The cabinet: 2 is eastbound, 4 southbound.
    fn today() -> ExistingPlan {
        plan(&[
            (1, [1, 1, 1], "WBL"),
            (2, [1, 1, 2], "EBT EBR ebl"),
            (5, [1, 2, 1], "EBL SBR"),
            (6, [1, 2, 2], "WBT WBR wbl"),
            (4, [2, 1, 1], "SBT SBR sbl"),
            (8, [2, 2, 1], "NBT NBR nbl"),
        ])
    }

    #[test]
    fn streets_and_directions_change_places_until_the_numbers_are_those_of_the_existing_plan() {
        let mut nema = plan(&[
            (1, [1, 1, 1], "NBL"),
            (2, [1, 1, 2], "SBT SBR sbl"),
            (6, [1, 2, 1], "NBT NBR nbl"),
            (3, [2, 1, 1], "EBL"),
            (4, [2, 1, 2], "WBT WBR wbl"),
            (8, [2, 2, 1], "EBT EBR ebl"),
        ]);
        nema.reference = vec![2, 6];
        let said = as_today(&mut nema, &today()).unwrap();
        let expected = plan(&[
            (2, [1, 1, 1], "EBT EBR ebl"),
            (5, [1, 2, 1], "EBL"),
            (6, [1, 2, 2], "WBT WBR wbl"),
            (3, [2, 1, 1], "NBL"),
            (4, [2, 1, 2], "SBT SBR sbl"),
            (8, [2, 2, 1], "NBT NBR nbl"),
        ]);
        assert_eq!((nema.phases, nema.reference), (expected.phases, vec![4, 8]));
        assert!(said.ends_with("2 = 8, 3 = 1, 4 = 2, 5 = 3, 6 = 4, 8 = 6."), "{said}");
    }

    #[test]
    fn equal_numbers_stay_and_nothing_is_said() {
        let mut same = today();
        assert_eq!(as_today(&mut same, &today()), None);
        assert_eq!(same, today());
    }

    #[test]
    fn numbers_that_no_exchange_makes_equal_stay_and_a_note_says_which_is_which() {
        let mut split = today();
        split.phases[4] = plan(&[(3, [2, 1, 1], "SBL SBT SBR")]).phases.remove(0);
        let mut nema = today();
        let said = as_today(&mut nema, &split).unwrap();
        assert_eq!(nema, today());
        assert!(said.ends_with("(here = there): 4 = 3."), "{said}");
    }
}
