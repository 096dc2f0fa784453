//! Existing plans as a table: one row per phase. The same table is read, written, and `cabinet.csv` of a report, which has the
//! columns `method` and `replicate` too.
//!
//! A table needs the columns of [`NEEDED`], and `max_green_s` or `split_s`; where both are given they have to agree. What is one
//! value per intersection may stand in any of its rows.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value as Json;
use sheet::{Fault, Row, Sheet};

use super::{
    Control, ExistingPlan, LEAST_GREEN_S, LIMITS, NamedPlan, PlanPhase, Plans, Recall, within,
};
use crate::vocabulary::Heading;
use basics::files::lines;
use evaluation::family::columns::{Columns, at};
use evaluation::family::error::FamilyError;
use evaluation::family::names::title;
use osm_signals::{DrivingSide, Turn};

/// Columns that a table needs.
pub const NEEDED: [&str; 9] = [
    "intersection", "control", "phase", "ring", "barrier", "position", "movements", "yellow_s",
    "all_red_s",
];

/// Other columns that a table may have; all but the first two are passed over.
const OTHERS: [&str; 7] =
    ["intersection", "period", "title", "signal", "kind", "method", "replicate"];

/// How far `split_s` may be from green, yellow and all-red, seconds: a digit after the point.
const SPLIT_SLACK_S: f64 = 0.051;

/// Shortest green where a table says none, seconds.
pub(crate) const SHORT_GREEN_S: f64 = 5.0;

/// Passage time where a table says none, seconds.
pub(crate) const EXTENSION_S: f64 = 3.0;

/// What a cell holds.
trait Value: Sized {
    /// What a message says is expected.
    const EXPECTED: &'static str;

    fn read(_: &str) -> Option<Self> {
        None
    }

    /// Reads a cell of a table, whose numbers may have decimal commas.
    fn of_cell(row: &Row, at: usize) -> Option<Self> {
        Self::read(row.text(at))
    }

    fn write(&self) -> String;
}

/// The columns of a phase and of its plan, in the order in which they are written.
macro_rules! columns {
    ($($name:ident: $kind:ty,)*) => {
        /// Columns of a phase and of its plan; before them stands what plan it is.
        pub const WRITTEN: &[&str] = &[$(stringify!($name)),*];

        #[derive(Default)]
        struct Cells {
            $($name: Option<$kind>,)*
        }

        impl Cells {
            fn read(row: &Row, columns: &Columns) -> Result<Self, String> {
                Ok(Self { $($name: cell(row, columns, stringify!($name))?,)* })
            }

            fn write(&self) -> Vec<String> {
                vec![$(self.$name.as_ref().map(Value::write).unwrap_or_default()),*]
            }
        }
    };
}

columns! {
    control: Control,
    cycle_s: f64,
    offset_s: f64,
    reference: Vec<u32>,
    referenced_to: u32,
    phase: (u32, Option<u32>),
    ring: u32,
    barrier: u32,
    position: u32,
    movements: Vec<String>,
    yielding: Vec<String>,
    min_green_s: f64,
    max_green_s: f64,
    split_s: f64,
    passage_s: f64,
    yellow_s: f64,
    all_red_s: f64,
    walk_s: f64,
    clearance_s: f64,
    recall: Recall,
    dual_entry: bool,
    inhibit_max: bool,
    min_split_s: f64,
    detectors: Box<str>,
}

impl Value for f64 {
    const EXPECTED: &'static str = "a number";

    fn of_cell(row: &Row, at: usize) -> Option<Self> {
        row.number(at).ok().flatten()
    }

    fn write(&self) -> String {
        self.to_string()
    }
}

impl Value for u32 {
    const EXPECTED: &'static str = "a whole number that is not negative";

    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }

    fn of_cell(row: &Row, at: usize) -> Option<Self> {
        f64::of_cell(row, at).filter(|n| n.fract() == 0.0 && *n >= 0.0).map(|n| n as Self)
    }

    fn write(&self) -> String {
        self.to_string()
    }
}

impl Value for Box<str> {
    const EXPECTED: &'static str = "words";

    fn read(text: &str) -> Option<Self> {
        Some(text.into())
    }

    fn write(&self) -> String {
        self.to_string()
    }
}

impl Value for (u32, Option<u32>) {
    const EXPECTED: &'static str = "a whole number, or two of a stage such as 2+6";

    fn of_cell(row: &Row, at: usize) -> Option<Self> {
        match row.text(at).split_once('+') {
            Some((one, other)) => Some((u32::read(one.trim())?, Some(u32::read(other.trim())?))),
            None => Some((u32::of_cell(row, at)?, None)),
        }
    }

    fn write(&self) -> String {
        let also = self.1.map_or_else(String::new, |also| format!("+{}", also.max(self.0)));
        format!("{}{also}", self.1.map_or(self.0, |also| also.min(self.0)))
    }
}

impl Value for bool {
    const EXPECTED: &'static str = "yes or no";

    fn read(text: &str) -> Option<Self> {
        match text.to_lowercase().as_str() {
            "1" | "yes" | "true" | "on" => Some(true),
            "0" | "no" | "false" | "off" => Some(false),
            _ => None,
        }
    }

    fn write(&self) -> String {
        if *self { "yes" } else { "no" }.to_owned()
    }
}

macro_rules! choices {
    ($($kind:ty: $expected:literal,)*) => {
        $(impl Value for $kind {
            const EXPECTED: &'static str = $expected;

            fn read(text: &str) -> Option<Self> {
                serde_json::from_value(text.to_lowercase().into()).ok()
            }

            fn write(&self) -> String {
                name(self)
            }
        })*
    };
}

choices! {
    Control: "one of pretimed, actuated, coordinated",
    Recall: "one of none, min, ped, max",
}

/// Returns the name of a control or a recall.
pub fn name(choice: &impl Serialize) -> String {
    let name = serde_json::to_value(choice).ok();
    name.as_ref().and_then(Json::as_str).unwrap_or_default().to_owned()
}

impl Value for String {
    const EXPECTED: &'static str = "names such as NBT NBR, where NB is northbound traffic and L, T, R are left, through, right";

    fn read(text: &str) -> Option<Self> {
        Some(text.to_uppercase()).filter(|name| movement(name).is_some())
    }

    fn write(&self) -> String {
        self.clone()
    }
}

impl<T: Value> Value for Vec<T> {
    const EXPECTED: &'static str = T::EXPECTED;

    fn read(text: &str) -> Option<Self> {
        let words = text.split(|c: char| !c.is_ascii_alphanumeric());
        words.filter(|word| !word.is_empty()).map(T::read).collect()
    }

    fn write(&self) -> String {
        self.iter().map(T::write).collect::<Vec<_>>().join(" ")
    }
}

/// Returns what a name of a movement says whatever the side that traffic keeps to: all but where U-turns lead.
fn movement(name: &str) -> Option<(Heading, Turn)> {
    Heading::of_movement(name, DrivingSide::default())
}

/// Returns the value of a column of a row; `None` where it is empty or there is no such column.
fn cell<T: Value>(row: &Row, columns: &Columns, name: &str) -> Result<Option<T>, String> {
    let Some(at) = columns.get(name).filter(|at| !row.text(*at).is_empty()) else {
        return Ok(None);
    };
    let limits = LIMITS.iter().find(|limits| limits.0 == name);
    if let Some((limits, number)) = limits.zip(row.number(at).ok().flatten()) {
        within(name, number, &limits.2)?;
    }
    let wrong = || format!("{name} = {:?}: expected {}", row.text(at), T::EXPECTED);
    T::of_cell(row, at).ok_or_else(wrong).map(Some)
}

/// Reads a table of existing plans.
pub fn read(text: &str, file: &str) -> Result<Plans, FamilyError> {
    let fail = |fault| at(file, fault);
    let mut sheet = Sheet::of(text).map_err(fail)?;
    let line = sheet.header_line;
    let wrong = |message| fail(Fault { line, message });
    let known = [&OTHERS[..], WRITTEN].concat();
    let columns = Columns::find(&sheet.headers, &NEEDED, &known).map_err(wrong)?;
    columns.only(&known).map_err(wrong)?;
    let mut plans: Vec<NamedPlan> = Vec::new();
    // What rows of a plan said before, and their lines.
    let mut told: Vec<(BTreeMap<&str, String>, Vec<u64>)> = Vec::new();
    while let Some(row) = sheet.next_row().map_err(fail)? {
        let line = row.line;
        let wrong = |message| fail(Fault { line, message });
        let text = |name: &str| columns.get(name).map(|at| row.text(at)).unwrap_or_default();
        let id = title("intersection", text("intersection")).map_err(wrong)?;
        let period = match text("period") {
            "" => String::new(),
            period => title("period", period).map_err(wrong)?,
        };
        let known = plans.iter().position(|plan| plan.intersection == id && plan.period == period);
        let index = known.unwrap_or_else(|| {
            let plan = ExistingPlan::new(Control::Pretimed, Vec::new());
            let plan = ExistingPlan { offset_s: None, ..plan };
            plans.push(NamedPlan { intersection: id, period, plan, line });
            told.push(Default::default());
            plans.len() - 1
        });
        for name in ["control", "cycle_s", "offset_s", "reference", "referenced_to"] {
            let said = text(name);
            if !said.is_empty()
                && told[index].0.entry(name).or_insert_with(|| said.to_owned()) != said
            {
                return Err(wrong(format!(
                    "{name} differs from that of a row above; give an intersection one value"
                )));
            }
        }
        let cells = Cells::read(&row, &columns).map_err(wrong)?;
        let plan = &mut plans[index].plan;
        plan.control = cells.control.unwrap_or(plan.control);
        plan.cycle_s = cells.cycle_s.or(plan.cycle_s);
        plan.offset_s = cells.offset_s.or(plan.offset_s);
        plan.referenced_to = cells.referenced_to.unwrap_or(plan.referenced_to);
        cells.reference.iter().for_each(|numbers| plan.reference.clone_from(numbers));
        plan.push(cells.phase().map_err(wrong)?);
        told[index].1.push(line);
    }
    for (named, (told, lines)) in plans.iter().zip(&told) {
        let empty = || (Vec::new(), "control is empty".to_owned());
        let known = told.contains_key("control").then_some(()).ok_or_else(empty);
        known.and_then(|()| named.plan.checked().map(|_| ())).map_err(|(phases, message)| {
            let at: Vec<u64> = phases.iter().map(|phase| lines[*phase]).collect();
            let all = if at.len() > 1 {
                format!(" (lines {})", at.iter().map(u64::to_string).collect::<Vec<_>>().join(", "))
            } else {
                String::new()
            };
            let message = format!("intersection {}: {message}{all}", named.intersection);
            fail(Fault { line: at.first().copied().unwrap_or(named.line), message })
        })?;
    }
    if plans.is_empty() {
        return Err(wrong("no phase; a table of plans has a row per phase".to_owned()));
    }
    Ok(Plans { file: file.to_owned(), all: plans, ..Plans::default() })
}

impl Cells {
    fn of(plan: &ExistingPlan, phase: &PlanPhase) -> Self {
        Self {
            control: Some(plan.control),
            cycle_s: plan.cycle_s,
            offset_s: plan.offset_s,
            reference: Some(plan.reference.clone()),
            referenced_to: Some(plan.referenced_to),
            phase: Some((phase.number, phase.also)),
            ring: Some(phase.ring),
            barrier: Some(phase.barrier),
            position: Some(phase.position),
            movements: Some(phase.movements.clone()),
            yielding: Some(phase.yielding.clone()),
            min_green_s: Some(phase.min_green_s),
            max_green_s: Some(phase.max_green_s),
            split_s: Some(rounded(phase.split_s())),
            passage_s: Some(phase.passage_s),
            yellow_s: Some(phase.yellow_s),
            all_red_s: Some(phase.all_red_s),
            walk_s: phase.walk_s.map(|[walk_s, _]| walk_s),
            clearance_s: phase.walk_s.map(|[_, clearance_s]| clearance_s),
            recall: Some(phase.recall),
            dual_entry: Some(phase.dual_entry),
            inhibit_max: Some(phase.inhibit_max),
            min_split_s: phase.min_split_s,
            detectors: Some(phase.detectors.as_str().into()),
        }
    }

    fn phase(self) -> Result<PlanPhase, String> {
        let empty = |name: &str| format!("{name} is empty; give a number");
        let yellow_s = self.yellow_s.ok_or_else(|| empty("yellow_s"))?;
        let all_red_s = self.all_red_s.ok_or_else(|| empty("all_red_s"))?;
        let left_s = |split_s: f64| split_s - yellow_s - all_red_s;
        let of_split = |split_s: f64| rounded(left_s(split_s)).max(LEAST_GREEN_S);
        let max_green_s = (self.max_green_s.or(self.split_s.map(of_split)))
            .ok_or("neither max_green_s nor split_s; give one of them")?;
        let unlike = |split_s: &f64| (left_s(*split_s) - max_green_s).abs() > SPLIT_SLACK_S;
        if let Some(split_s) = self.split_s.filter(unlike) {
            return Err(format!(
                "split_s = {split_s}, but green, yellow and all-red are {} s together; correct one of them, or leave split_s or \
                 max_green_s empty",
                rounded(max_green_s + yellow_s + all_red_s)
            ));
        }
        let walk_s = self.walk_s.filter(|s| *s > 0.0);
        let clearance_s = self.clearance_s.filter(|s| *s > 0.0);
        if walk_s.is_some() != clearance_s.is_some()
            || self.recall == Some(Recall::Ped) && walk_s.is_none()
        {
            return Err(
                "walk_s and clearance_s belong together, and recall ped needs them; give both, or none where no crosswalk is \
                 beside the phase"
                    .to_owned(),
            );
        }
        let movements = self.movements.unwrap_or_default();
        let has_through = movements.iter().any(|m| matches!(movement(m), Some((_, Turn::Through))));
        let (number, also) = self.phase.ok_or_else(|| empty("phase"))?;
        Ok(PlanPhase {
            number,
            also,
            ring: self.ring.ok_or_else(|| empty("ring"))?,
            barrier: self.barrier.ok_or_else(|| empty("barrier"))?,
            position: self.position.ok_or_else(|| empty("position"))?,
            movements,
            yielding: self.yielding.unwrap_or_default(),
            min_green_s: self.min_green_s.unwrap_or(SHORT_GREEN_S.min(max_green_s)),
            max_green_s,
            min_split_s: self.min_split_s,
            passage_s: self.passage_s.unwrap_or(EXTENSION_S),
            yellow_s,
            all_red_s,
            walk_s: walk_s.zip(clearance_s).map(<[f64; 2]>::from),
            recall: self.recall.unwrap_or_default(),
            dual_entry: self.dual_entry.unwrap_or(has_through),
            inhibit_max: self.inhibit_max.unwrap_or(false),
            detectors: self.detectors.map_or_else(String::new, String::from),
        })
    }
}

/// Returns a time without digits that come from adding tenths, seconds.
fn rounded(seconds: f64) -> f64 {
    (seconds * 1000.0).round() / 1000.0
}

/// Returns the cells of a phase in the order of [`WRITTEN`].
pub fn cells(plan: &ExistingPlan, phase: &PlanPhase) -> Vec<String> {
    Cells::of(plan, phase).write()
}

/// Returns plans as a table, which reads back as the same.
pub fn to_csv(plans: &[NamedPlan]) -> String {
    let header = ["intersection", "period"].iter().chain(WRITTEN);
    let mut rows: Vec<Vec<String>> = vec![header.map(|name| (*name).to_owned()).collect()];
    for NamedPlan { intersection, period, plan, .. } in plans {
        for phase in &plan.phases {
            let whose = [intersection.clone(), period.clone()];
            rows.push(whose.into_iter().chain(cells(plan, phase)).collect());
        }
    }
    String::from_utf8(lines(&rows)).expect("texts are UTF-8")
}

#[cfg(test)]
mod tests {
    use super::super::testing::plans;
    use super::*;

    const HEADER: &str = "intersection,control,cycle_s,phase,ring,barrier,position,movements,yielding,split_s,yellow_s,all_red_s";

    proptest::proptest! {
        #[test]
        fn plans_that_were_written_read_back_as_the_same(plan in plans(), other in plans()) {
            let named = |period: &str, plan, line| NamedPlan {
                intersection: "Oak / Main".into(),
                period: period.into(),
                plan,
                line,
            };
            let am = named("am", plan, 2);
            let pm = named("pm", other, 2 + am.plan.phases.len() as u64);
            let both = [am, pm];
            let text = to_csv(&both);
            proptest::prop_assert_eq!(&read(&text, "e.csv").unwrap().all[..], &both);
            // As in a sheet for the cabinet.
            let text = text.replace("\nOak", "\nnema,0,c,phase,A,Oak");
            let text = format!("method,replicate,signal,kind,title,{text}");
            proptest::prop_assert_eq!(&read(&text, "e.csv").unwrap().all[..], &both);
        }
    }

    #[test]
    fn green_and_split_have_to_agree_and_one_of_them_is_enough() {
        let header = format!("{HEADER},max_green_s");
        let read_it = |first: &str, second: &str| {
            let rows = format!(
                "7,pretimed,60,2,1,1,1,NBT NBR,NBL,{first}\n7,,,4,1,2,1,\"EBT, EBR\",ebl,{second}\n"
            );
            read(&format!("{header}\n{rows}"), "e.csv").map_err(|e| e.to_string())
        };
        let plans = read_it("30,4,1,", ",4,1,25").unwrap();
        let phases = &plans.all[0].plan.phases;
        assert_eq!([0, 1].map(|p: usize| phases[p].max_green_s), [25.0, 25.0]);
        let names = [&phases[1].movements, &phases[1].yielding].map(|names| names.join(" "));
        assert_eq!(names, ["EBT EBR", "EBL"]);
        assert_eq!((phases[1].min_green_s, phases[1].passage_s), (5.0, 3.0));
        assert!(phases[1].dual_entry && plans.all[0].plan.offset_s.is_none());
        for (second, expected) in [
            ("30,4,1,26", "line 3: split_s = 30, but green, yellow and all-red are 31 s"),
            ("4,4,1,", "line 3: split_s = 4, but green, yellow and all-red are 5.1 s"),
            (",4,1,", "line 3: neither max_green_s nor split_s"),
            ("-43,4,1,", "line 3: split_s = -43: expected 0.1 to 930"),
            ("43,4,1,-37.5", "line 3: max_green_s = -37.5: expected 0.1 to 900"),
            ("35,4,1,", "line 2: intersection 7: the cycle is 60 s, but the splits"),
        ] {
            let e = read_it("30,4,1,25", second).unwrap_err();
            assert!(e.contains(expected), "{e}");
        }
        let rows =
            "a,pretimed,60,1,1,1,1,NBT,,30,4,1\na,,,2,1,2,1,EBT,,30,4,1\na,,,3,2,2,1,WBT,,35,4,1";
        for (from, to, expected) in [
            (
                "",
                "",
                "before barrier 2, 35 s in ring 2 before barrier 2); correct the cycle or a green (lines 3, 4)",
            ),
            ("3,2,2,1", "3,3,2,1", "line 4: ring = 3: expected 1 to 2"),
            ("yellow_s,", "", "no column yellow_s; add it"),
        ] {
            let table = format!("{HEADER}\n{rows}\n").replacen(from, to, 1);
            let e = read(&table, "e.csv").unwrap_err().to_string();
            assert!(e.contains(expected), "{e}");
        }
    }
}
