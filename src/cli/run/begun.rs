//! What of a run is there already: a command in its folder adds to it.

use crate::cli::exit::{Refused, refuse};
use std::path::Path;

use serde_json::Value;

use crate::cli::subject::Subject;
use crate::family::MdpFamily;
use crate::sample::{Choice, Design, Sampling, choose_over};
use crate::store::Layout;
use crate::store::error::StoreError;
use crate::store::manifest::{Identity, Manifest};

use super::arguments::RunArgs;

/// A run that is there, of the scenario that is asked for.
pub(super) struct Begun {
    layout: Layout,
    /// What is kept of the settings of the run whose scores assist its sample.
    pub(super) assisting: Option<Value>,
    pub(super) identity: Identity,
}

impl Begun {
    /// Returns the run in a folder that a command adds to; `None` where there is none of this scenario, or one of a sample
    /// that grows look by look.
    pub(super) fn find(
        args: &RunArgs,
        subject: &Subject,
        out: &Path,
    ) -> anyhow::Result<Option<Self>> {
        let mut layout = Layout::new(out);
        let mut read = Manifest::read(&layout);
        if matches!(read, Err(StoreError::Adding(_))) {
            layout = Layout::new(layout.adding());
            read = Manifest::read(&layout);
        }
        // Whatever else is wrong with it is said where the run is opened.
        let Ok(Manifest { identity, provenance }) = read else { return Ok(None) };
        let is_other = identity.domain != subject.domain.name()
            || identity.scenario != subject.problem.family().name;
        if is_other || identity.sample.growth.is_some() || args.until_decided {
            return Ok(None);
        }
        let given: Vec<String> = args.controllers.names().collect();
        if let Some(own) = identity.controllers.iter().find(|own| !given.contains(&own.name)) {
            let (out, name) = (out.display(), &own.name);
            return refuse(format!(
                "{out} has the controller {name} ({}), which is not given; give it again, or another --out",
                own.source
            ));
        }
        Ok(Some(Self { layout, assisting: provenance.assisting, identity }))
    }

    /// Returns its methods, and after them those that are asked for besides.
    pub(super) fn with(&self, asked: Vec<String>) -> Vec<String> {
        let mut all = self.identity.methods.clone();
        let more: Vec<String> = asked.into_iter().filter(|method| !all.contains(method)).collect();
        all.extend(more);
        all
    }

    /// Returns which point MDPs it has.
    pub(super) fn choice(&self) -> anyhow::Result<Choice> {
        let sample = &self.identity.sample;
        if sample.sampling == Sampling::All {
            return Ok(Choice::All);
        }
        let bytes = self.layout.document("design.json")?;
        // One that is damaged is named where the run is opened.
        let design: Option<Design> = bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok());
        Ok(Choice::Sample { sample: sample.clone(), design, assisting: self.assisting.clone() })
    }

    /// Whether it has a sample in which no method assists its own estimate.
    pub(super) fn is_apart(&self) -> bool {
        matches!(self.choice(), Ok(Choice::Sample { design: Some(design), .. }) if !design.apart.is_empty())
    }

    /// Returns a sample of another size, drawn as the one that it has and over the same design.
    pub(super) fn with_budget(&self, budget: usize, family: &MdpFamily) -> anyhow::Result<Choice> {
        let there = self.choice()?;
        let (sample, design, assisting) = match &there {
            Choice::Sample { sample, design, assisting }
                if (design.is_some() || !sample.sampling.has_design())
                    && there.sample(family, 0).is_ok() =>
            {
                (sample, design.clone(), assisting.clone())
            }
            // What is there is a whole family, or of another one, which is said where the run is opened; or it lacks its
            // design, which is then drawn again.
            _ => return Ok(Choice::drawn(budget, Sampling::DEFAULT)),
        };
        let over = design.clone().unwrap_or_else(|| Design::of(family));
        let sample = choose_over(family, &over, sample.sampling, budget, sample.seed);
        let sample = sample.map_err(|e| Refused(e.to_string()))?;
        Ok(Choice::Sample { sample, design, assisting })
    }
}

/// Returns the sample of the run in another folder, without the looks at which it grew.
pub(super) fn like(dir: &Path) -> anyhow::Result<Choice> {
    let layout = Layout::new(dir);
    let Manifest { mut identity, provenance } = Manifest::read(&layout)?;
    identity.sample.growth = None;
    Begun { layout, assisting: provenance.assisting, identity }.choice()
}
