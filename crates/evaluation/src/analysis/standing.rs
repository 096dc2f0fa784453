//! Where a sample that grows stands: whether it says enough.

use super::{Analysis, Decided};
use crate::sample::Until;

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
        let mut open = Vec::new();
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
                open = pairs.iter().filter(|pair| !self.is_decided(pair)).cloned().collect();
                open.is_empty()
            }
        };
        // Methods that lack results may lack what decides.
        let is_enough = is_enough && self.missing() == 0;
        Some(Standing {
            look: sample.look()? + 1,
            looks: growth.looks.len(),
            is_enough,
            open,
            widest,
        })
    }

    fn is_decided(&self, (first, second): &(String, String)) -> bool {
        let name = |m: usize| self.methods[m].method.as_str();
        let both = [first.as_str(), second.as_str()];
        let found = self.comparison.pairs.iter().find(|p| {
            let named = [name(p.first), name(p.second)];
            named == both || [named[1], named[0]] == both
        });
        // Where one of them failed may be what decides.
        let everywhere = |p: &&super::Pair| p.points == self.points.len();
        found
            .filter(everywhere)
            .is_some_and(|p| matches!(p.decided(), Decided::First | Decided::Second))
    }
}
