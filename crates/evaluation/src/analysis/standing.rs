//! Where a sample that grows stands: whether it says enough.

use super::{Analysis, Decided, MethodSummary, Pair};
use crate::sample::Until;
use crate::sample::behind::{Compared, behind};
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
    /// Pairs of methods that were asked about and are not decided.
    pub open: Vec<(String, String)>,
    /// Methods that say nothing more about what is open: they are surely behind another one.
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
        let (open, compared) = match &growth.until {
            Until::Decided(pairs) => {
                let pairs = pairs.iter().map(|(a, b)| [a.as_str(), b.as_str()]);
                let stay = pairs.filter(|pair| !pair.iter().any(|m| self.is_dropped(m)));
                let compared: Vec<_> = stay.map(|pair| self.compared(pair)).collect();
                (named(&mut compared.iter().filter(|pair| pair.ahead.is_none())), compared)
            }
            Until::FirstPlace(methods) => {
                let stays = |m: &&str| methods.iter().any(|n| n == m) && !self.is_dropped(m);
                let ranking = self.methods.iter().map(|m| m.method.as_str());
                let stay: Vec<&str> = ranking.filter(stays).collect();
                let after = |i: usize| stay.iter().skip(i + 1).map(move |b| (i, *b));
                let pairs = (0..stay.len()).flat_map(after).map(|(i, b)| [stay[i], b]);
                let compared: Vec<_> = pairs.map(|pair| self.compared(pair)).collect();
                let is_open = |pair: &&Compared<&str>| {
                    pair.methods[0] == stay[0] && pair.ahead != Some(stay[0])
                };
                (named(&mut compared.iter().filter(is_open)), compared)
            }
        };
        let behind = self.dropping(&behind(&growth.until, &compared), look);
        // Methods that lack results may lack what decides.
        let is_enough = open.is_empty() && self.missing() == 0;
        Some(Standing { look, looks: growth.looks.len(), is_enough, open, behind })
    }

    fn scorable(&self) -> usize {
        self.reference.index.map_or(self.points.len(), |index| self.results_of(index).count())
    }

    fn is_dropped(&self, method: &str) -> bool {
        self.results.dropped.iter().any(|dropped| dropped.method == method)
    }

    /// Returns that methods drop out after a look, counted from 1, in the order of the ranking; never what scores are
    /// divided by.
    fn dropping(&self, behind: &[(&str, &str)], look: usize) -> Vec<Dropped> {
        let of = |m: &MethodSummary| {
            let (method, rival) = behind.iter().find(|(method, _)| *method == m.method)?;
            let dropped = Dropped { method: (*method).into(), look, behind: (*rival).into() };
            (!m.is_reference).then_some(dropped)
        };
        self.methods.iter().filter_map(of).collect()
    }

    fn compared<'a>(&self, methods: [&'a str; 2]) -> Compared<&'a str> {
        Compared { methods, ahead: self.winner(methods[0], methods[1]) }
    }

    fn winner<'a>(&self, first: &'a str, second: &'a str) -> Option<&'a str> {
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
        let is_first = name(found.first) == first;
        match found.decided() {
            Decided::First => Some(if is_first { first } else { second }),
            Decided::Second => Some(if is_first { second } else { first }),
            Decided::Open | Decided::Unknown => None,
        }
    }
}

fn named(pairs: &mut dyn Iterator<Item = &Compared<&str>>) -> Vec<(String, String)> {
    pairs.map(|pair| (pair.methods[0].to_owned(), pair.methods[1].to_owned())).collect()
}
