//! Results on a whole family, read for estimators.

use std::path::Path;

use crate::analysis::Analysis;
use crate::domains;
use crate::store::Layout;
use crate::study::Recorded;

/// Reads results on a whole family.
pub(super) fn read(dir: &Path) -> anyhow::Result<(Recorded, Analysis)> {
    let layout = Layout::new(dir);
    let results = domains::load(&layout)?;
    let sections = domains::sections(&layout, &results)?;
    let analysis = Analysis::new(&results, sections.measures());
    Ok((Recorded::of(&analysis, &dir.display().to_string())?, analysis))
}
