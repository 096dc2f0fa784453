//! Where a sample that grows stands: whether it says enough.

use super::{Analysis, Decided, Pair};
use crate::store::dropped::Dropped;

/// Where a sample that grows stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Look of the sample, from 1.
    pub look: usize,
    /// Number of looks.
    pub looks: usize,
    /// Whether what was asked for is reached.
    pub is_enough: bool,
    /// The answer, with the methods that may be as good or better.
    pub answer: Option<(String, Vec<String>)>,
    /// The best method so far with each against which it may lose more than is asked for.
    pub open: Vec<(String, String)>,
    /// Methods that cannot be the best: they are surely behind another one.
    pub behind: Vec<Dropped>,
}

impl Standing {
    /// Whether there is another look, and a reason for it.
    pub fn goes_on(&self) -> bool {
        !self.is_enough && self.look < self.looks
    }
}

impl Analysis {
    /// Returns where the sample stands; `None` where it does not grow.
    pub fn standing(&self) -> Option<Standing> {
        let sample = &self.manifest.identity.sample;
        let growth = sample.growth.as_ref()?;
        let look = sample.look()? + 1;
        let (methods, within) = growth.until.question();
        let dropped = &self.results.dropped;
        let stays = |m: &&str| {
            methods.iter().any(|n| n == m) && !dropped.iter().any(|dropped| dropped.method == *m)
        };
        let ranking = self.methods.iter().map(|m| m.method.as_str());
        let stay: Vec<&str> = ranking.filter(stays).collect();
        let is_ahead = |a: &str, b: &str| self.winner(a, b) == Some(a);
        let loses = |a: &str, b: &str| a != b && !self.is_within(a, b, within);
        let is_answer = |a: &&&str| !stay.iter().any(|b| loses(a, b));
        let answer = stay.iter().find(is_answer).map(|answer| {
            let others = stay.iter().filter(|other| *other != answer && !is_ahead(answer, other));
            ((*answer).to_owned(), others.map(|other| (*other).to_owned()).collect())
        });
        let open = stay.iter().skip(1).filter(|m| answer.is_none() && loses(stay[0], m));
        let open: Vec<_> = open.map(|m| (stay[0].to_owned(), (*m).to_owned())).collect();
        // What scores are divided by never drops out.
        let droppable = self.methods.iter().filter(|m| !m.is_reference && stays(&&*m.method));
        let behind = droppable.filter_map(|m| {
            let ahead = stay.iter().find(|other| is_ahead(other, &m.method))?;
            Some(Dropped { method: m.method.clone(), look, behind: (*ahead).to_owned() })
        });
        let behind = behind.collect();
        // Methods that lack results may lack what decides.
        let is_enough = answer.is_some() && self.missing() == 0;
        Some(Standing { look, looks: growth.looks.len(), is_enough, answer, open, behind })
    }

    fn scorable(&self) -> usize {
        self.reference.index.map_or(self.points.len(), |index| self.results_of(index).count())
    }

    /// Whether the first method loses at most so much against the second, by the interval of their difference; within 0 it
    /// is ahead by more than chance.
    fn is_within(&self, first: &str, second: &str, within: f64) -> bool {
        let Some((pair, is_first)) = self.pair(first, second) else { return false };
        match pair.ahead.interval {
            _ if within == 0.0 => self.winner(first, second) == Some(first),
            Some((low, high)) => {
                pair.fragile.is_empty() && if is_first { -low <= within } else { high <= within }
            }
            None => false,
        }
    }

    /// Returns the comparison of two methods on all point MDPs, and whether the first of them comes first in it.
    fn pair(&self, first: &str, second: &str) -> Option<(&Pair, bool)> {
        let name = |m: usize| self.methods[m].method.as_str();
        let of = |p: &&Pair| {
            let named = [name(p.first), name(p.second)];
            named == [first, second] || named == [second, first]
        };
        let found = self.comparison.pairs.iter().find(of)?;
        // Where one of them failed, in one training or all, may be what decides.
        let partly = self.partly_replicated();
        let is_whole = ![first, second].iter().any(|method| partly.contains(method));
        let found = Some(found).filter(|p| is_whole && p.points == self.scorable())?;
        Some((found, name(found.first) == first))
    }

    /// Returns which of two methods is ahead by more than chance on all point MDPs, if one is.
    fn winner<'a>(&self, first: &'a str, second: &'a str) -> Option<&'a str> {
        let (found, is_first) = self.pair(first, second)?;
        match found.decided() {
            Decided::First => Some(if is_first { first } else { second }),
            Decided::Second => Some(if is_first { second } else { first }),
            Decided::Open | Decided::Unknown => None,
        }
    }
}
