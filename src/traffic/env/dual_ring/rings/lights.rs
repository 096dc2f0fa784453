//! What the rings make of the links: who stays green, who turns yellow, who may turn green.

use osm_signals::Turn;

use super::{Rings, Stage};

impl Rings {
    /// Lets rings change: what ends turns yellow.
    ///
    /// # Arguments
    ///
    /// * `hold` — whether links that are green before and after stay green.
    pub(super) fn change(&mut self, changes: &[(usize, Option<usize>)], hold: bool) {
        let next_links = |next: Option<usize>| match next {
            Some(next) => self.plan.phases[next].links.as_slice(),
            None => &[],
        };
        let mut coming = vec![false; self.links.count()];
        for (_, next) in changes {
            next_links(*next).iter().for_each(|link| coming[*link] = true);
        }
        let mut stages = self.stages.clone();
        let old: Vec<Option<usize>> = (changes.iter())
            .map(|(ring, _)| match self.stages[*ring] {
                Stage::Green { phase, .. } => Some(phase),
                _ => None,
            })
            .collect();
        for (ring, next) in changes {
            let mut held = Vec::new();
            if hold && let Stage::Green { phase, .. } = self.stages[*ring] {
                let own = &self.plan.phases[phase].links;
                let stays = |link: &&usize| coming[**link] && self.green[**link];
                held.extend(own.iter().filter(stays));
            }
            stages[*ring] = Stage::Change { next: *next, left_s: 0, held };
        }
        self.stages = stages;
        let before = self.green.clone();
        let mut barred = vec![false; before.len()];
        loop {
            let mut after = self.staying();
            after.iter_mut().zip(&barred).for_each(|(after, barred)| *after &= !barred);
            let traps = |link: usize, other: usize| {
                let ends =
                    before[link] && !after[link] && self.links.turn(link) == Some(Turn::Left);
                ends && after[other] && self.links.yields(link, other)
            };
            let count = after.len();
            let trap: Vec<bool> =
                (0..count).map(|other| (0..count).any(|link| traps(link, other))).collect();
            if !trap.contains(&true) {
                self.end(&before, &after, changes, &old);
                return;
            }
            for stage in &mut self.stages {
                if let Stage::Change { held, .. } = stage {
                    held.retain(|link| !trap[*link]);
                }
            }
            // What stays by a phase that goes on has nobody who yields to it and ends; see `plan`.
            barred.iter_mut().zip(trap).for_each(|(barred, trap)| *barred |= trap);
        }
    }

    /// Lets links end that do not stay, and times the rings that change.
    ///
    /// # Arguments
    ///
    /// * `old` — the phases that were green in those rings.
    fn end(
        &mut self,
        before: &[bool],
        after: &[bool],
        changes: &[(usize, Option<usize>)],
        old: &[Option<usize>],
    ) {
        let letters = |green: &[bool]| -> String {
            green.iter().map(|green| if *green { 'G' } else { 'r' }).collect()
        };
        let change = self.timing.change(&letters(before), &letters(after));
        let (yellow_s, total_s) = change.map_or((0, 0), |c| (c.yellow_s, c.total_s()));
        for link in (0..before.len()).filter(|l| before[*l] && !after[*l]) {
            self.yellow_s[link] = yellow_s;
            self.clearing_s[link] = total_s;
        }
        let (_, coming) = self.claimed();
        for ((ring, _), old) in changes.iter().zip(old) {
            // A left turn that stays green but loses its right of way takes its change as well.
            let phase = old.map(|old| &self.plan.phases[old]);
            let loses = |link: &usize| {
                after[*link] && (0..coming.len()).any(|o| coming[o] && self.links.yields(*link, o))
            };
            let own_s = phase
                .filter(|phase| phase.links.iter().any(loses))
                .map_or(0, |phase| phase.change_s.0 + phase.change_s.1);
            if let Stage::Change { left_s, .. } = &mut self.stages[*ring] {
                *left_s = total_s.max(own_s);
            }
        }
        self.green = after.to_vec();
    }

    /// Returns the links that are green by a phase, and those that are about to be.
    fn claimed(&self) -> (Vec<bool>, Vec<bool>) {
        let (mut now, mut coming) =
            (vec![false; self.links.count()], vec![false; self.links.count()]);
        for stage in &self.stages {
            match stage {
                Stage::Idle => {}
                Stage::Green { phase, .. } => {
                    self.plan.phases[*phase].links.iter().for_each(|link| now[*link] = true);
                }
                Stage::Change { next, held, .. } => {
                    held.iter().for_each(|link| now[*link] = true);
                    let next = next.iter().flat_map(|p| &self.plan.phases[*p].links);
                    next.for_each(|link| coming[*link] = true);
                }
            }
        }
        (now, coming)
    }

    /// Returns the links that are green now and stay so with what the rings do.
    fn staying(&self) -> Vec<bool> {
        let (now, coming) = self.claimed();
        let mut stay: Vec<bool> = now.iter().zip(&self.green).map(|(a, b)| *a && *b).collect();
        for &link in &self.plan.overlaps {
            let free = self.is_free(link, &now)
                && self.is_free(link, &coming)
                && self.links.fits(link, &stay);
            stay[link] |= self.green[link] && free;
        }
        stay
    }

    /// Whether a link may be green beside others, and none of them would yield to it.
    fn is_free(&self, link: usize, others: &[bool]) -> bool {
        let yields = |other: usize| others[other] && self.links.yields(other, link);
        self.links.fits(link, others) && !(0..others.len()).any(yields)
    }

    /// Turns green what is to be.
    pub(super) fn light(&mut self) {
        let (now, coming) = self.claimed();
        let mut green = self.staying();
        for link in 0..green.len() {
            green[link] |= now[link];
        }
        let clearing: Vec<bool> = self.clearing_s.iter().map(|s| *s > 0).collect();
        for &link in &self.plan.overlaps {
            green[link] |= self.clearing_s[link] == 0
                && self.is_free(link, &now)
                && self.is_free(link, &coming)
                && self.links.fits(link, &green)
                && self.is_free(link, &clearing);
        }
        self.green = green;
    }

    pub(super) fn state(&self) -> String {
        let (_, coming) = self.claimed();
        let letters = self.links.letters(&self.green, &coming);
        let letter = |(link, letter): (usize, u8)| match letter {
            b'r' if self.yellow_s[link] > 0 => 'y',
            letter => char::from(letter),
        };
        letters.into_iter().enumerate().map(letter).collect()
    }
}
