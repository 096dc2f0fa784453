//! `tsc-family report`.

use super::ReportArgs;
use super::output::{line, note};
use crate::cli::exit;
use crate::report::{self, ReportData, text};
use crate::store::Layout;
use crate::store::results::Results;

pub(super) fn run(args: &ReportArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let results = Results::load(&layout)?;
    let data = match &args.against {
        Some(method) => ReportData::against(&results, method)?,
        None => ReportData::new(&results),
    };
    print(&layout, &data, args.json, true)?;
    Ok(exit::DONE)
}

/// Writes a report and prints its table, or with `json` its methods; `notes` go to standard error.
pub(super) fn print(
    layout: &Layout,
    data: &ReportData,
    json: bool,
    notes: bool,
) -> anyhow::Result<()> {
    let paths = report::write_data(layout, data)?;
    if json {
        for row in data.json_rows() {
            line(super::run::method_line(&row))?;
        }
    } else {
        line(text::table(data))?;
    }
    if notes {
        for text in text::notes(data) {
            note(text);
        }
        if let Some(reason) = paths.plans_missing {
            note(format!(
                "no plans/*.winner.sumocfg of some point MDPs: {reason}; report from the folder that the \
                 run was started in, with its networks"
            ));
        }
        note(format!("report: {}", paths.html.display()));
    }
    Ok(())
}
