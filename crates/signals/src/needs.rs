//! What greens must be long enough for, counted over all greens in a row that serve it.
//!
//! A need is a movement or a crosswalk with the time that it takes, and the greens that serve it. While greens
//! that serve it follow each other, its time goes on; only before a green that does not serve it must it be
//! over. So a short green between two others need not last as long as its crosswalks alone would ask for.

/// What greens must be long enough for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Need {
    /// Which greens serve it.
    pub served: Vec<bool>,
    /// Time that it takes, seconds.
    pub least_s: u32,
    /// Number of the crosswalk, if it is one.
    pub crossing: Option<usize>,
}

impl Need {
    /// Returns the need of one green of several: a time that it lasts by itself.
    pub fn of_green(green: usize, greens: usize, least_s: u32) -> Self {
        Self { served: (0..greens).map(|i| i == green).collect(), least_s, crossing: None }
    }
}

/// Returns the shortest greens of a cycle, seconds: together with the changes within a row of greens that serve
/// a need, they last as long as it takes. What a row lacks is added to its longest green, the first of equals.
/// * `cycle` — greens, as numbers in [`Need::served`].
/// * `change_s` — yellow and all-red from one green to another, seconds.
pub fn least_greens_s(
    needs: &[Need],
    cycle: &[usize],
    change_s: &dyn Fn(usize, usize) -> u32,
) -> Vec<u32> {
    let count = cycle.len();
    let mut least = vec![0; count];
    for need in needs {
        let on = |place: usize| need.served[cycle[place % count]];
        if count == 1 && on(0) {
            least[0] = need.least_s.max(least[0]);
        }
        for start in (0..count).filter(|k| on(*k) && !on(k + count - 1)) {
            // A green before it does not serve the need, so the row ends.
            let row: Vec<usize> = (start..).take_while(|k| on(*k)).map(|k| k % count).collect();
            let between = row.windows(2).map(|w| change_s(cycle[w[0]], cycle[w[1]]));
            let lasts_s = row.iter().map(|k| least[*k]).sum::<u32>() + between.sum::<u32>();
            let longest = row.iter().copied().rev().max_by_key(|k| least[*k]);
            if let Some(longest) = longest {
                least[longest] += need.least_s.saturating_sub(lasts_s);
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(served: [bool; 3], least_s: u32) -> Need {
        Need { served: served.to_vec(), least_s, crossing: None }
    }

    #[test]
    fn a_row_of_greens_and_the_changes_in_it_carry_a_need_together() {
        let mut needs: Vec<Need> = (0..3).map(|i| Need::of_green(i, 3, 5)).collect();
        let least = |needs: &[Need]| least_greens_s(needs, &[0, 1, 2], &|_, _| 4);
        needs.push(need([true, false, false], 7));
        assert_eq!(least(&needs), [7, 5, 5]);
        needs.push(need([true, true, false], 19));
        assert_eq!(least(&needs), [10, 5, 5], "10 + 4 + 5 s");
        // The row goes on from the last green to the first; 5 + 4 + 10 + 4 + 5 s are more than enough.
        needs.push(need([true, true, true], 90));
        needs.push(need([true, false, true], 25));
        assert_eq!(least(&needs), [16, 5, 5], "5 + 4 + 16 s");
    }

    #[test]
    fn a_cycle_of_one_green_lasts_what_that_needs() {
        assert_eq!(least_greens_s(&[Need::of_green(0, 1, 7)], &[0], &|_, _| 0), [7]);
    }
}
