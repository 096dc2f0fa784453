//! A city: what a survey of its map found, less the intersections that cannot be in the family.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use osm_signals::listing::ListMatch;
use osm_signals::traffic::{ArmTraffic, InflowSource};
use osm_signals::{DrivingSide, Intersection, Place, Survey};

use super::flag::Flag;
use super::one_green::has_one_green;
use super::reason::Reason;
use crate::settings::InflowSources;

/// Digits after the point of a share, as a power of ten.
const SHARE: f64 = 10_000.0;

/// An intersection of a city.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    /// How it was found.
    pub found: &'a Intersection,
    /// Its traffic by arm.
    pub traffic: &'a [ArmTraffic],
    /// Whether all its streams can have green at the same time.
    pub one_green: bool,
}

impl Site<'_> {
    /// Returns what is worth a look, the most doubtful first.
    pub fn flags(&self) -> Vec<Flag> {
        let map = self.found.all_flags().into_iter().map(Flag::Map);
        self.one_green.then_some(Flag::OneGreen).into_iter().chain(map).collect()
    }
}

/// A signal, or several of one junction, that is no intersection of the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkippedSite<'a> {
    /// Ids of the signal nodes.
    pub signals: &'a [i64],
    /// Where the first of them is.
    pub place: Place,
    /// Why.
    pub reason: Reason,
}

/// The intersections of a city.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct City {
    survey: Survey,
    /// Side of the street that traffic keeps to.
    pub side: DrivingSide,
    /// By intersection of the survey whether all its streams can have green at the same time.
    one_green: Vec<bool>,
    /// By intersection of the survey why it is left out.
    reasons: Vec<Option<Reason>>,
    /// Those that are left out, in the order in which they were.
    out: Vec<usize>,
    /// Intersections without a sound network, and why.
    pub left_out: BTreeMap<String, String>,
}

impl City {
    /// Returns the city of a survey.
    pub fn new(survey: Survey, side: DrivingSide) -> Self {
        let all = &survey.found.intersections;
        let one_green = all.iter().map(|i| has_one_green(i, side)).collect();
        let reasons = vec![None; all.len()];
        Self { survey, side, one_green, reasons, out: Vec::new(), left_out: BTreeMap::new() }
    }

    /// Says that the turns of intersections were counted, so that their inflows rest on that.
    pub fn count_by_turn(&mut self, ids: &BTreeSet<String>) {
        let all = self.survey.found.intersections.iter().zip(&mut self.survey.traffic);
        for (intersection, traffic) in all.filter(|(i, _)| ids.contains(&i.id)) {
            for (arm, traffic) in intersection.arms.iter().zip(traffic) {
                if arm.lanes_in > 0 {
                    (traffic.source, traffic.count) = (InflowSource::Counted, None);
                }
            }
        }
    }

    /// Returns what was found, with the intersections that are left out.
    pub fn survey(&self) -> &Survey {
        &self.survey
    }

    /// Returns the intersections.
    pub fn sites(&self) -> impl Iterator<Item = Site<'_>> {
        let found = self.survey.found.intersections.iter().zip(&self.survey.traffic);
        let all = found.zip(&self.one_green).zip(&self.reasons);
        all.filter(|(_, reason)| reason.is_none()).map(|(((found, traffic), one_green), _)| Site {
            found,
            traffic,
            one_green: *one_green,
        })
    }

    /// Returns the signals that are no intersection.
    pub fn skipped(&self) -> impl Iterator<Item = SkippedSite<'_>> {
        let map = self.survey.found.skipped.iter().map(|s| SkippedSite {
            signals: &s.signals,
            place: s.place,
            reason: Reason::Map(s.reason),
        });
        let out = self.out.iter().filter_map(|index| {
            let (i, reason) = (&self.survey.found.intersections[*index], self.reasons[*index]?);
            Some(SkippedSite { signals: &i.signals, place: i.centre, reason })
        });
        map.chain(out)
    }

    /// Returns the rows of the signal list, with the reason why the intersection of one is left out.
    pub fn listed(&self) -> impl Iterator<Item = (&ListMatch, Option<Reason>)> {
        let left_out: BTreeMap<&str, Reason> = (self.out.iter())
            .filter_map(|i| {
                Some((self.survey.found.intersections[*i].id.as_str(), self.reasons[*i]?))
            })
            .collect();
        self.survey.listed.iter().map(move |row| {
            let id = row.intersection.as_deref();
            (row, id.and_then(|id| left_out.get(id).copied()))
        })
    }

    /// Takes intersections out for which no sound network can be built, each with the reason.
    pub fn leave_out(&mut self, reasons: BTreeMap<String, String>) {
        self.take_out(|i, _| reasons.contains_key(&i.id), Reason::NoNetwork);
        self.left_out.extend(reasons);
    }

    /// Takes intersections out at which nothing is to decide, and returns how many.
    ///
    /// As six features they stand for an intersection that has more than one green; built with their own arms
    /// they have a score without any meaning.
    ///
    /// # Arguments
    ///
    /// * `built` — ids of those whose network turned out to have one green.
    pub fn leave_out_one_green(&mut self, built: &BTreeSet<String>) -> usize {
        self.take_out(|i, one_green| one_green || built.contains(&i.id), Reason::OneGreen)
    }

    fn take_out(&mut self, which: impl Fn(&Intersection, bool) -> bool, reason: Reason) -> usize {
        let before = self.out.len();
        for (index, i) in self.survey.found.intersections.iter().enumerate() {
            if self.reasons[index].is_none() && which(i, self.one_green[index]) {
                self.reasons[index] = Some(reason);
                self.out.push(index);
            }
        }
        self.out.len() - before
    }

    /// Returns what the inflows rest on, shares of the approaches with four digits.
    pub fn inflow_sources(&self) -> InflowSources {
        let arms = self.sites().flat_map(|site| site.found.arms.iter().zip(site.traffic));
        let approaches = arms.filter(|(arm, _)| arm.lanes_in > 0);
        let sources: Vec<InflowSource> = approaches.map(|(_, traffic)| traffic.source).collect();
        let [counted, spread, imputed, default] = InflowSource::ALL.map(|source| {
            let n = sources.iter().filter(|s| **s == source).count();
            (n as f64 / sources.len().max(1) as f64 * SHARE).round() / SHARE
        });
        InflowSources { counted, spread, imputed, default, by_turn: 0.0 }
    }

    /// Returns how many signals are no intersection, by reason, most frequent first.
    pub fn skips(&self) -> Vec<(Reason, usize)> {
        let mut counts = BTreeMap::new();
        for skipped in self.skipped() {
            *counts.entry(skipped.reason).or_default() += skipped.signals.len().max(1);
        }
        let mut counts: Vec<(Reason, usize)> = counts.into_iter().collect();
        counts.sort_by_key(|(reason, n)| (Reverse(*n), *reason));
        counts
    }
}
