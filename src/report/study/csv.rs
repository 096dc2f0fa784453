//! `errors.csv`: a row per estimator, budget and method.

use super::whole::StudyReport;

/// Returns `errors.csv`.
pub(super) fn errors(report: &StudyReport<'_>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = [
        "method",
        "estimator",
        "budget",
        "repeats",
        "truth",
        "mean",
        "deviation",
        "rmse",
        "coverage",
        "half_width",
        "cpu_hours",
    ];
    writer.write_record(header).expect("memory can be written to");
    for cell in report.cells {
        let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
        let row = [
            cell.method.clone(),
            cell.kind.name().to_owned(),
            cell.budget.to_string(),
            cell.repeats.to_string(),
            cell.truth.to_string(),
            cell.mean.to_string(),
            cell.deviation.to_string(),
            cell.error.to_string(),
            number(cell.coverage),
            number(cell.half_width),
            number(cell.cpu_hours),
        ];
        writer.write_record(row).expect("memory can be written to");
    }
    writer.into_inner().expect("memory can be written to")
}
