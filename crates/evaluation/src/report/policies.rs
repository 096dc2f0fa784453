//! Which policies of their trainings the learners are ranked by, in words.

use super::format;
use super::whole::Report;
use crate::analysis::LearnerSummary;

/// Says by which policies the learners are ranked, what their last policies would have scored, and which trainings
/// started again or ended with a dead network.
pub(super) fn sentences(data: &Report) -> Vec<String> {
    let learners = data.learners();
    let mut sentences: Vec<String> = learners.iter().filter_map(|l| chosen(l)).collect();
    let by_last: Vec<&str> = (learners.iter())
        .filter(|l| l.scored > 0 && l.validated == 0)
        .map(|l| l.method.method.as_str())
        .collect();
    if !by_last.is_empty() {
        let is = if by_last.len() == 1 { "is" } else { "are" };
        sentences.push(format!(
            "{} {is} ranked by the last policy of each training; validation did not choose among policies.",
            by_last.join(", ")
        ));
    }
    for l in &learners {
        let of = format::count(l.scored, "training");
        let name = &l.method.method;
        if l.restarted > 0 {
            sentences.push(format!(
                "{} of {of} of {name} started again from another seed, because the network was dead.",
                l.restarted
            ));
        }
        if l.dead > 0 {
            sentences.push(format!(
                "{} of {of} of {name} ended with a dead network, which acts the same whatever it sees.",
                l.dead
            ));
        }
    }
    sentences
}

/// Says what validation changed for a learner; `None` where it chose nothing.
fn chosen(l: &LearnerSummary<'_>) -> Option<String> {
    let (overall, last) = l.method.overall.zip(l.last_policy)?;
    let (name, of) = (&l.method.method, format::count(l.validated, "training"));
    Some(match l.replaced {
        0 => format!(
            "{name} is ranked by the last policy of each training: in none of {of} did validation find a better one."
        ),
        n => format!(
            "{name} is ranked by the policies that validation chose ({}). The last policies score {}; validation \
             replaced them in {n} of {of}.",
            format::score(overall),
            format::score(last)
        ),
    })
}
