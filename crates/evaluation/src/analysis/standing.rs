//! Where a sample that grows stands: whether it says enough.

use super::{Analysis, Decided, Pair};
use crate::sample::Until;
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
    /// The method with the widest interval, and its half-width; `None` where that is not asked for, and for a method without
    /// interval.
    pub widest: Option<(String, Option<f64>)>,
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
        let (mut open, mut behind) = (Vec::new(), Vec::new());
        let mut widest = None;
        let is_enough = match &growth.until {
            Until::HalfWidth(most) => {
                let width = |(low, high): (f64, f64)| (high - low) / 2.0;
                // Of a method that failed somewhere, what it lacks may decide.
                let whole = |m: &super::MethodSummary| m.points == self.points.len();
                let of = |m: &super::MethodSummary| {
                    (m.method.clone(), m.interval.filter(|_| whole(m)).map(width))
                };
                let judged = self.methods.iter().filter(|m| !m.is_reference).map(of);
                let rank = |w: Option<f64>| w.unwrap_or(f64::INFINITY);
                widest = judged.max_by(|a, b| rank(a.1).total_cmp(&rank(b.1)));
                widest.as_ref().is_none_or(|(_, width)| rank(*width) <= *most)
            }
            Until::Decided(pairs) => {
                let both_stay =
                    |(a, b): &&(String, String)| !self.is_dropped(a) && !self.is_dropped(b);
                let is_open = |pair: &&(String, String)| self.winner(&pair.0, &pair.1).is_none();
                open = pairs.iter().filter(both_stay).filter(is_open).cloned().collect();
                let is_done = |m: &str| !open.iter().any(|(a, b)| rival(m, a, b).is_some());
                let rivals = |m: &str| pairs.iter().filter_map(|(a, b)| rival(m, a, b)).collect();
                let methods = self.methods.iter().map(|m| m.method.as_str());
                let done = methods.filter(|m| is_done(m));
                behind = done.filter_map(|m| self.behind(m, rivals(m), look)).collect();
                open.is_empty()
            }
            Until::FirstPlace(methods) => {
                let stays = |m: &&str| methods.iter().any(|n| n == m) && !self.is_dropped(m);
                let ranking = self.methods.iter().map(|m| m.method.as_str());
                let stay: Vec<&str> = ranking.filter(stays).collect();
                let pairs = stay.iter().skip(1).map(|m| (stay[0], *m));
                let is_open = |(first, m): &(&str, &str)| self.winner(first, m) != Some(first);
                let named = |(a, b): (&str, &str)| (a.to_owned(), b.to_owned());
                open = pairs.filter(is_open).map(named).collect();
                let rivals = |m: &str| stay.iter().copied().filter(|other| *other != m).collect();
                behind = stay.iter().filter_map(|m| self.behind(m, rivals(m), look)).collect();
                open.is_empty()
            }
        };
        // Methods that lack results may lack what decides.
        let is_enough = is_enough && self.missing() == 0;
        Some(Standing { look, looks: growth.looks.len(), is_enough, open, widest, behind })
    }

    fn is_dropped(&self, method: &str) -> bool {
        self.results.dropped.iter().any(|dropped| dropped.method == method)
    }

    /// Returns that a method is surely behind one of these, if it is, at a look counted from 1.
    fn behind(&self, method: &str, rivals: Vec<&str>, look: usize) -> Option<Dropped> {
        let wins = |rival: &&str| self.winner(rival, method) == Some(*rival);
        let rival = rivals.into_iter().find(wins)?;
        let is_reference = self.methods.iter().any(|m| m.method == method && m.is_reference);
        (!is_reference && !self.is_dropped(method)).then(|| Dropped {
            method: method.to_owned(),
            look,
            behind: rival.to_owned(),
        })
    }

    /// Returns which of two methods is ahead by more than chance on all point MDPs, if one is.
    fn winner<'a>(&self, first: &'a str, second: &'a str) -> Option<&'a str> {
        let name = |m: usize| self.methods[m].method.as_str();
        let of = |p: &&Pair| {
            let named = [name(p.first), name(p.second)];
            named == [first, second] || named == [second, first]
        };
        let found = self.comparison.pairs.iter().find(of)?;
        // Where one of them failed may be what decides.
        let found = Some(found).filter(|p| p.points == self.points.len())?;
        let is_first = name(found.first) == first;
        match found.decided() {
            Decided::First => Some(if is_first { first } else { second }),
            Decided::Second => Some(if is_first { second } else { first }),
            Decided::Open | Decided::Unknown => None,
        }
    }
}

/// Returns the other method of a pair; `None` where the method is in neither place.
fn rival<'a>(method: &str, first: &'a str, second: &'a str) -> Option<&'a str> {
    match (first == method, second == method) {
        (true, _) => Some(second),
        (_, true) => Some(first),
        _ => None,
    }
}
