//! `tsc-family report`.

use super::ReportArgs;
use super::output::{line, note};
use crate::exit;
use crate::report::{self, data::ReportData, text};
use crate::store::Layout;
use crate::store::results::Results;

pub(super) fn run(args: &ReportArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let data = ReportData::new(&Results::load(&layout)?);
    let paths = report::write_data(&layout, &data)?;
    if args.json {
        for row in data.json_rows() {
            line(super::run::method_line(&row))?;
        }
    } else {
        line(text::table(&data))?;
    }
    for text in text::notes(&data) {
        note(text);
    }
    note(format!("report: {}", paths.html.display()));
    Ok(exit::DONE)
}
