//! Training one learner on several point MDPs: to a run they are one point MDP, whose row in the manifest has them as its
//! members. Plan, executors, checkpoints, records and models need not know.
//!
//! - **Order**: every episode is on the member that lacks most of its share, which is half equal and half by weight.
//! - **Objective**: the mean over members with weights `w / b`, of which `b` is what the baseline has there. So the ratio to
//!   the baseline is the mean of the members' ratios.
//! - **Judges**: members after those that are trained on are played in validation and evaluation only.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::domain::{Prepared, PreparedPoint, Problem};
use super::error::RunError;
use super::fault::Cause;
use super::plan::row;
use crate::family::{MdpFamily, PointMdp};
use crate::sample::{Choice, Draw, Sampling};
use crate::store::figures::ABOVE_BASELINE;
use crate::store::manifest::PointRow;
use crate::store::record::Metrics;
use basics::hash::sha256;

/// Environment of a point MDP that has members, and where its row keeps them.
pub const TOGETHER: &str = "together";

/// The members of a point MDP; none by default.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Together {
    /// Those that are trained on, then those that only judge; their importance is their weight here.
    pub members: Vec<PointRow>,
    /// How many are trained on.
    pub trained: usize,
    /// Index of the member of every training episode.
    pub schedule: Vec<usize>,
    /// What the baseline has on each: the objective, and whatever rewards are scaled by.
    #[serde(skip)]
    pub baseline: Vec<[f64; 2]>,
}

impl Together {
    /// Returns the members of a point MDP; none of an ordinary one.
    /// The error is what is wrong with a manifest that no run writes.
    pub fn of(point: &PointRow) -> Result<Self, String> {
        if point.environment != TOGETHER {
            return Ok(Self::default());
        }
        let given = point.given.get(TOGETHER).cloned().unwrap_or_default();
        let this: Self = serde_json::from_value(given).map_err(|e| format!("{TOGETHER}: {e}"))?;
        let is_plain = |m: &PointRow| m.environment != TOGETHER && m.importance > 0.0;
        let is_whole = (1..=this.members.len()).contains(&this.trained)
            && this.members.iter().all(is_plain)
            && this.schedule.iter().all(|member| *member < this.trained);
        is_whole.then_some(this).ok_or_else(|| format!("{TOGETHER}: no run writes such members"))
    }

    /// Returns what a record says of the members, by their names.
    pub fn details(&self) -> impl Iterator<Item = (String, String)> + '_ {
        self.members.iter().zip(&self.baseline).map(|(member, [objective, scale])| {
            let weight = member.importance;
            let said = format!("weight {weight}, baseline {objective}, rewards times {scale}");
            (format!("{TOGETHER} {}", member.point), said)
        })
    }

    /// Returns the mean over the members of what was measured on each, and how many are worse than the baseline.
    pub fn mean(&self, all: &[Metrics], objective: &str) -> Metrics {
        let shares = self.members.iter().zip(&self.baseline).map(|(m, b)| m.importance / b[0]);
        let total: f64 = shares.clone().sum();
        let everywhere = |name: &&String| all.iter().all(|metrics| metrics.contains_key(*name));
        let mean = |name: &String| {
            let sum: f64 = all.iter().zip(shares.clone()).map(|(m, share)| m[name] * share).sum();
            (name.clone(), sum / total)
        };
        let mut means: Metrics = all[0].keys().filter(everywhere).map(mean).collect();
        let above = all.iter().zip(&self.baseline).filter(|(m, b)| m[objective] > b[0]).count();
        means.insert(ABOVE_BASELINE.to_owned(), above as f64);
        means
    }
}

/// Some point MDPs of a problem as one.
pub struct Joint {
    inner: Box<dyn Problem>,
    family: MdpFamily,
    /// Indices of the members in the family of the problem, with their weights.
    members: Vec<(usize, f64)>,
    trained: usize,
    schedule: Vec<usize>,
}

impl Joint {
    /// Returns a sample of a problem, and one of those that are not in it, as one point MDP.
    ///
    /// # Arguments
    ///
    /// * `trained`, `judges` — how many.
    /// * `episodes` — of the training.
    ///
    /// # Errors
    ///
    /// [`RunError`] when there are not as many, or not each would be visited.
    pub fn new(
        inner: Box<dyn Problem>,
        (trained, judges): (usize, usize),
        sampling: Sampling,
        seed: u64,
        episodes: usize,
    ) -> Result<Self, RunError> {
        let family = inner.family();
        let draws = |family: &MdpFamily, budget| -> Result<Vec<Draw>, RunError> {
            let choice = match family.points.len() == budget {
                true => Choice::All,
                false => Choice::Budget { budget, sampling, design: None, assisting: None },
            };
            let mut draws = choice.sample(family, seed)?.0.draws;
            draws.retain(|draw| draw.weight > 0.0);
            Ok(draws)
        };
        let mut chosen = draws(family, trained)?;
        let trained = chosen.len();
        let mut rest = family.points.clone();
        rest.retain(|p| p.importance > 0.0 && !chosen.iter().any(|draw| draw.point == p.id));
        let judges = judges.min(rest.len());
        if judges > 0 {
            let total: f64 = rest.iter().map(|p| p.importance).sum();
            rest.iter_mut().for_each(|p| p.importance /= total);
            let rest = MdpFamily::new(&*family.name, family.features.clone(), rest, "the rest")?;
            chosen.extend(draws(&rest, judges)?);
        }
        // Each of the two samples counts by its size.
        let (all, judges) = (chosen.len() as f64, chosen.len() - trained);
        let sizes = [trained, judges].into_iter().flat_map(|n| vec![n as f64 / all; n]);
        let index = |draw: &Draw| family.position(&draw.point).expect("it was drawn");
        let members: Vec<(usize, f64)> =
            chosen.iter().zip(sizes).map(|(d, size)| (index(d), d.weight * size)).collect();
        let weights: Vec<f64> = members[..trained].iter().map(|(_, weight)| *weight).collect();
        let schedule = schedule(&weights, episodes);
        let visited: BTreeSet<&usize> = schedule.iter().collect();
        if visited.len() < trained {
            return Err(RunError::Refused(format!(
                "{episodes} training episodes visit {} of {trained} point MDPs; give more --episodes",
                visited.len()
            )));
        }
        let point = PointMdp {
            id: format!("{trained}-together"),
            title: format!("{trained} point MDPs together"),
            features: Vec::new(),
            importance: 1.0,
            instances: members[..trained].iter().map(|(i, _)| family.points[*i].instances).sum(),
        };
        let family = MdpFamily::new(&*family.name, Vec::new(), vec![point], "--on")?;
        Ok(Self { family, members, trained, schedule, inner })
    }

    /// Returns the ids of the members.
    fn chosen(&self) -> BTreeSet<&str> {
        let points = &self.inner.family().points;
        self.members.iter().map(|(i, _)| points[*i].id.as_str()).collect()
    }
}

impl Problem for Joint {
    fn family(&self) -> &MdpFamily {
        &self.family
    }

    fn settings(&self) -> Value {
        self.inner.settings()
    }

    fn prepare(&self, _: &BTreeSet<&str>, done: &(dyn Fn(&str) + Sync)) -> Result<Prepared, Cause> {
        let Prepared { simulator, folder, mut points } =
            self.inner.prepare(&self.chosen(), done)?;
        let member = |(i, weight): &(usize, f64)| {
            let point = &self.inner.family().points[*i];
            let made = points.remove(&point.id).ok_or(RunError::Unprepared(point.id.clone()))?;
            Ok(PointRow { importance: *weight, ..row(point, made) })
        };
        let members = self.members.iter().map(member).collect::<Result<Vec<_>, RunError>>()?;
        let contents: Vec<&str> = members.iter().map(|m| m.content.as_str()).collect();
        let content = sha256(json!([self.trained, contents]).to_string().as_bytes());
        let (trained, schedule) = (self.trained, self.schedule.clone());
        let together = Together { members, trained, schedule, baseline: Vec::new() };
        let together = serde_json::to_value(together).expect("plain data");
        let given = [(TOGETHER.to_owned(), together)].into();
        let environment = TOGETHER.to_owned();
        let made = PreparedPoint { environment, content, given, ..PreparedPoint::default() };
        let points = [(self.family.points[0].id.clone(), made)].into();
        Ok(Prepared { simulator, folder, points })
    }

    fn lacking(&self, method: &str, _: &BTreeSet<&str>) -> Option<String> {
        self.inner.lacking(method, &self.chosen())
    }

    fn warnings(&self) -> Result<Vec<String>, Cause> {
        self.inner.warnings()
    }
}

/// Returns the member of each of so many episodes.
fn schedule(weights: &[f64], episodes: usize) -> Vec<usize> {
    let (total, equal) = (weights.iter().sum::<f64>(), 1.0 / weights.len() as f64);
    let mut due = vec![0.0; weights.len()];
    let next = |_| {
        due.iter_mut().zip(weights).for_each(|(due, w)| *due += (equal + w / total) / 2.0);
        let later = |a: &usize, b: &usize| due[*a].total_cmp(&due[*b]).then(b.cmp(a));
        let next = (0..due.len()).max_by(later).expect("there are members");
        due[next] -= 1.0;
        next
    };
    (0..episodes).map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_take_turns_by_half_equal_and_half_weighted_shares() {
        assert_eq!(schedule(&[0.75, 0.25], 8), [0, 1, 0, 0, 1, 0, 1, 0]);
    }
}
