//! Existing plans as a table: one row per phase.
//!
//! Columns that a table needs: `intersection`, `control` (`pretimed`, `actuated`, `coordinated`), `phase`, `ring`,
//! `barrier`, `position`, `movements`, `max_green_s` or `split_s`, `yellow_s`, `all_red_s`. Others may be missing; see
//! [`OPTIONAL`]. What is one value per intersection may stand in any of its rows.
//!
//! The sheet for the cabinet that a report writes (`cabinet.csv`) is such a table, with the columns `method` and `replicate`.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use sheet::{Fault, Row, Sheet};

use super::{
    ALL_RED_S, CYCLE_S, Control, ExistingPlan, GREEN_S, MIN_GREEN_S, MOST_NUMBER, NamedPlan,
    OFFSET_S, PASSAGE_S, PEOPLE_S, PlanPhase, Plans, Recall, YELLOW_S,
};
use crate::vocabulary::Heading;
use basics::files::lines;
use basics::suggest::did_you_mean;
use evaluation::family::columns::{Columns, at};
use evaluation::family::error::FamilyError;
use evaluation::family::names::title;
use evaluation::settings::within;
use osm_signals::{DrivingSide, Turn};

/// Columns that a table needs.
pub const COLUMNS: [&str; 9] = [
    "intersection", "control", "phase", "ring", "barrier", "position", "movements", "yellow_s",
    "all_red_s",
];

/// Columns that may be missing; one of `max_green_s` and `split_s` is needed, and where both are given they have to agree.
pub const OPTIONAL: [&str; 15] = [
    "period", "yielding", "min_green_s", "max_green_s", "split_s", "passage_s", "walk_s",
    "clearance_s", "recall", "dual_entry", "inhibit_max", "cycle_s", "offset_s", "reference",
    "referenced_to",
];

/// Columns of a phase and of its plan, in the order in which they are written; before them stands what plan it is.
pub const WRITTEN: [&str; 22] = [
    "control", "cycle_s", "offset_s", "reference", "referenced_to", "phase", "ring", "barrier",
    "position", "movements", "yielding", "min_green_s", "max_green_s", "split_s", "passage_s",
    "yellow_s", "all_red_s", "walk_s", "clearance_s", "recall", "dual_entry", "inhibit_max",
];

/// Columns that say of which plan a report's table is: all rows of a table that is read have to be of one.
const WHOSE: [&str; 2] = ["method", "replicate"];

/// Columns of a report's table that are passed over.
const PASSED_OVER: [&str; 3] = ["title", "signal", "kind"];

/// How far `split_s` may be from green, yellow and all-red, seconds: a digit after the point.
const SPLIT_SLACK_S: f64 = 0.051;

/// Shortest green where a table says none, seconds.
const SHORT_GREEN_S: f64 = 5.0;

/// Passage time where a table says none, seconds.
const EXTENSION_S: f64 = 3.0;

/// Split, seconds.
const SPLIT_S: RangeInclusive<f64> = 0.1..=930.0;

/// What is one value per intersection.
#[derive(Default, Clone, PartialEq)]
struct Whole {
    control: Option<Control>,
    cycle_s: Option<f64>,
    offset_s: Option<f64>,
    reference: Option<Vec<u32>>,
    referenced_to: Option<u32>,
}

/// Reads a table of existing plans.
///
/// # Errors
///
/// [`FamilyError::Csv`] with file and line: a column that is missing or unknown, a value out of range, a plan that cannot
/// be shown.
pub fn read(text: &str, file: &str) -> Result<Plans, FamilyError> {
    let fail = |fault| at(file, fault);
    let mut sheet = Sheet::of(text).map_err(fail)?;
    let no_phase = |line| {
        let message = "no phase; a table of plans has a header, and a row per phase below it";
        fail(Fault::new(line, message.to_owned()))
    };
    if sheet.headers().iter().all(str::is_empty) {
        return Err(no_phase(1));
    }
    let header_line = sheet.header_line();
    let known = [&COLUMNS[..], &OPTIONAL, &WHOSE, &PASSED_OVER].concat();
    if let Some(message) = other_table(sheet.headers().iter(), &known) {
        return Err(fail(Fault::new(header_line, message)));
    }
    let columns = Columns::find(sheet.headers(), &COLUMNS)
        .and_then(|columns| columns.only(&known).map(|()| columns))
        .and_then(|columns| match (columns.get("max_green_s"), columns.get("split_s")) {
            (None, None) => Err("no column max_green_s; add it, or split_s".to_owned()),
            _ => Ok(columns),
        })
        .map_err(|message| fail(Fault::new(header_line, message)))?;
    let mut plans: Vec<(NamedPlan, Whole)> = Vec::new();
    let mut position: BTreeMap<(String, String), usize> = BTreeMap::new();
    let mut whose: Option<[String; 2]> = None;
    while let Some(row) = sheet.next_row().map_err(fail)? {
        let line = row.line;
        let wrong = |message| fail(Fault { line, message });
        let fields = Fields { row: &row, columns: &columns };
        let own = WHOSE.map(|name| fields.text(name).to_owned());
        let first = whose.get_or_insert_with(|| own.clone());
        if *first != own {
            return Err(wrong(several(first, &own)));
        }
        let id = title("intersection", fields.text("intersection")).map_err(wrong)?;
        let period = match fields.text("period") {
            "" => String::new(),
            period => title("period", period).map_err(wrong)?,
        };
        let index = *position.entry((id.clone(), period.clone())).or_insert_with(|| {
            let plan = ExistingPlan::new(Control::Pretimed, Vec::new());
            plans.push((NamedPlan { intersection: id, period, plan, line }, Whole::default()));
            plans.len() - 1
        });
        let (named, whole) = &mut plans[index];
        fields.whole(whole).map_err(wrong)?;
        named.plan.phases.push(fields.phase().map_err(wrong)?);
    }
    if plans.is_empty() {
        return Err(no_phase(header_line));
    }
    let mut all = Vec::new();
    for (mut named, whole) in plans {
        let wrong = |message: String| {
            let message = format!("intersection {}: {message}", named.intersection);
            fail(Fault { line: named.line, message })
        };
        let Some(control) = whole.control else {
            return Err(wrong(format!("control is empty; give {}", controls())));
        };
        named.plan.control = control;
        named.plan.cycle_s = whole.cycle_s;
        // Without one, the plan begins with the simulation.
        named.plan.offset_s = Some(whole.offset_s.unwrap_or_default());
        named.plan.reference = whole.reference.unwrap_or_default();
        named.plan.referenced_to = whole.referenced_to.unwrap_or_default();
        named.plan.check().map_err(wrong)?;
        all.push(named);
    }
    Ok(Plans { file: file.to_owned(), all, ..Plans::default() })
}

/// Says what a table is whose header is none of a table of plans; `None` where it may be one.
fn other_table<'a>(names: impl Iterator<Item = &'a str>, known: &[&str]) -> Option<String> {
    let names: Vec<String> = names.map(str::to_lowercase).collect();
    let has = |name: &str| names.iter().any(|n| n == name);
    if has("bearing_deg") || has("lanes_in") {
        return Some("a table of approaches, no plans; give it as the scenario".to_owned());
    }
    (!known.iter().any(|name| has(name))).then(|| {
        format!(
            "none of its columns belongs to a table of plans; begin with a header of names: {}, and max_green_s or split_s",
            COLUMNS.join(", ")
        )
    })
}

/// Says that rows are of several plans.
fn several(first: &[String; 2], other: &[String; 2]) -> String {
    let (what, [a, b]) = match first[0] != other[0] {
        true => ("methods", [&first[0], &other[0]]),
        false => ("trainings", [&first[1], &other[1]]),
    };
    format!(
        "rows are of several {what} ({a}, {b}); keep those of one, or give plans/METHOD.csv of the report, which has one"
    )
}

/// Returns a time without digits that come from adding tenths, seconds.
fn rounded(seconds: f64) -> f64 {
    (seconds * 1000.0).round() / 1000.0
}

/// Returns the names of the kinds of control as messages list them.
fn controls() -> String {
    Control::ALL.map(Control::name).join(", ")
}

/// A row by the names of its columns.
struct Fields<'a> {
    row: &'a Row,
    columns: &'a Columns,
}

impl Fields<'_> {
    fn text(&self, name: &str) -> &str {
        self.columns.get(name).map(|at| self.row.text(at)).unwrap_or_default()
    }

    /// Returns a number within limits; `None` where there is none.
    fn number(&self, name: &str, range: RangeInclusive<f64>) -> Result<Option<f64>, String> {
        if self.columns.get(name).is_none() {
            return Ok(None);
        }
        let Some(value) = self.columns.optional(self.row, name)? else { return Ok(None) };
        within(value, *range.start(), *range.end())
            .map_err(|expected| format!("{name} = {value}: {expected}"))?;
        Ok(Some(value))
    }

    /// Returns a number within limits that has to be there.
    fn needed(&self, name: &str, range: RangeInclusive<f64>) -> Result<f64, String> {
        self.number(name, range)?.ok_or_else(|| format!("{name} is empty; give a number"))
    }

    /// Returns a whole number from 1.
    fn place(&self, name: &str) -> Result<u32, String> {
        match self.columns.whole(self.row, name)? {
            0 => Err(format!("{name} = 0: expected a whole number from 1")),
            number if number > MOST_NUMBER => {
                Err(format!("{name} = {number}: expected at most {MOST_NUMBER}"))
            }
            number => Ok(number),
        }
    }

    /// Returns yes or no; `None` where nothing is said.
    fn flag(&self, name: &str) -> Result<Option<bool>, String> {
        match self.text(name).to_lowercase().as_str() {
            "" => Ok(None),
            "1" | "yes" | "true" | "on" => Ok(Some(true)),
            "0" | "no" | "false" | "off" => Ok(Some(false)),
            other => Err(format!("{name} = {other:?}: expected yes or no")),
        }
    }

    /// Returns one of some words; `None` where nothing is said.
    fn word<T: Copy>(
        &self,
        name: &str,
        all: &[T],
        word: fn(T) -> &'static str,
    ) -> Result<Option<T>, String> {
        let text = self.text(name).to_lowercase();
        if text.is_empty() {
            return Ok(None);
        }
        let words: Vec<&str> = all.iter().map(|value| word(*value)).collect();
        let found = words.iter().position(|word| *word == text);
        found.map(|i| Some(all[i])).ok_or_else(|| {
            let meant = did_you_mean(&text, words.iter().copied());
            format!("{name} = {text:?}: expected one of {}{meant}", words.join(", "))
        })
    }

    /// Takes what is one value per intersection.
    fn whole(&self, whole: &mut Whole) -> Result<(), String> {
        fn put<T: PartialEq>(
            name: &str,
            into: &mut Option<T>,
            new: Option<T>,
        ) -> Result<(), String> {
            match (&into, new) {
                (Some(old), Some(new)) if *old != new => Err(format!(
                    "{name} differs from that of a row above; give an intersection one value"
                )),
                (None, new @ Some(_)) => {
                    *into = new;
                    Ok(())
                }
                _ => Ok(()),
            }
        }
        put("control", &mut whole.control, self.word("control", &Control::ALL, Control::name)?)?;
        put("cycle_s", &mut whole.cycle_s, self.number("cycle_s", CYCLE_S)?)?;
        put("offset_s", &mut whole.offset_s, self.number("offset_s", OFFSET_S)?)?;
        let reference = self.text("reference");
        let numbers =
            reference.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty());
        let numbers: Result<Vec<u32>, String> = numbers
            .map(|word| {
                word.parse().map_err(|_| {
                    format!("reference = {reference:?}: expected numbers of phases, such as 2 6")
                })
            })
            .collect();
        put("reference", &mut whole.reference, Some(numbers?).filter(|all| !all.is_empty()))?;
        let to = self.number("referenced_to", 0.0..=9.0)?.map(|number| number as u32);
        put("referenced_to", &mut whole.referenced_to, to)
    }

    /// Returns the longest green: what is given as such, or what yellow and all-red leave of the split.
    fn green_s(&self, yellow_s: f64, all_red_s: f64) -> Result<f64, String> {
        let split_s = self.number("split_s", SPLIT_S)?;
        match (self.number("max_green_s", GREEN_S)?, split_s) {
            (Some(green_s), Some(split_s))
                if (split_s - green_s - yellow_s - all_red_s).abs() > SPLIT_SLACK_S =>
            {
                Err(format!(
                    "split_s = {split_s}, but green, yellow and all-red are {} s together; correct one of them, or leave \
                     split_s or max_green_s empty",
                    rounded(green_s + yellow_s + all_red_s)
                ))
            }
            (Some(green_s), _) => Ok(green_s),
            (None, Some(split_s)) if split_s <= yellow_s + all_red_s => Err(format!(
                "split_s = {split_s}: nothing is left for green after {yellow_s} s of yellow and {all_red_s} s of \
                 all-red; give more, or put the green into a column max_green_s"
            )),
            (None, Some(split_s)) => Ok(rounded(split_s - yellow_s - all_red_s)),
            (None, None) => {
                let columns = ["split_s", "max_green_s"];
                let column = columns.into_iter().find(|name| self.columns.get(name).is_some());
                Err(format!("{} is empty; give a number", column.unwrap_or("max_green_s")))
            }
        }
    }

    fn phase(&self) -> Result<PlanPhase, String> {
        let yellow_s = self.needed("yellow_s", YELLOW_S)?;
        let all_red_s = self.needed("all_red_s", ALL_RED_S)?;
        let number = self.place("phase")?;
        let max_green_s = self.green_s(yellow_s, all_red_s)?;
        let walk_s = self.number("walk_s", PEOPLE_S)?.filter(|s| *s > 0.0);
        let clearance_s = self.number("clearance_s", PEOPLE_S)?.filter(|s| *s > 0.0);
        let walk_s = match (walk_s, clearance_s) {
            (Some(walk_s), Some(clearance_s)) => Some([walk_s, clearance_s]),
            (None, None) => None,
            _ => {
                return Err(
                    "walk_s and clearance_s belong together; give both, or none where no crosswalk is beside the phase"
                        .to_owned(),
                );
            }
        };
        let min_green_s = self.number("min_green_s", MIN_GREEN_S)?;
        let recall = self.word("recall", &Recall::ALL, Recall::name)?.unwrap_or_default();
        if recall == Recall::Ped && walk_s.is_none() {
            return Err(
                "recall is ped without walk_s and clearance_s; give both, or another recall"
                    .to_owned(),
            );
        }
        let movements = names("movements", self.text("movements"))?;
        let has_through = movements.iter().any(|m| matches!(movement(m), Some((_, Turn::Through))));
        Ok(PlanPhase {
            number,
            ring: self.place("ring")?,
            barrier: self.place("barrier")?,
            position: self.place("position")?,
            movements,
            yielding: names("yielding", self.text("yielding"))?,
            min_green_s: min_green_s.unwrap_or(SHORT_GREEN_S.min(max_green_s)),
            max_green_s,
            passage_s: self.number("passage_s", PASSAGE_S)?.unwrap_or(EXTENSION_S),
            yellow_s,
            all_red_s,
            walk_s,
            recall,
            dual_entry: self.flag("dual_entry")?.unwrap_or(has_through),
            inhibit_max: self.flag("inhibit_max")?.unwrap_or(false),
        })
    }
}

/// Returns what a name of a movement says whatever the side that traffic keeps to: all but where U-turns lead.
fn movement(name: &str) -> Option<(Heading, Turn)> {
    Heading::of_movement(name, DrivingSide::default())
}

/// Returns the names of movements in a field.
fn names(column: &str, text: &str) -> Result<Vec<String>, String> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words
        .map(|word| {
            let name = word.to_uppercase();
            match movement(&name) {
                Some(_) => Ok(name),
                None => Err(format!(
                    "{column} = {text:?}: {word} is no movement; expected names such as NBT NBR, where NB is northbound \
                     traffic and L, T, R are left, through, right"
                )),
            }
        })
        .collect()
}

/// Returns the cells of a phase in the order of [`WRITTEN`].
pub fn cells(plan: &ExistingPlan, phase: &PlanPhase) -> Vec<String> {
    let number = |value: f64| value.to_string();
    let optional = |value: Option<f64>| value.map(number).unwrap_or_default();
    let yes = |flag: bool| if flag { "yes" } else { "no" }.to_owned();
    let reference: Vec<String> = plan.reference.iter().map(u32::to_string).collect();
    let [walk_s, clearance_s] = [0, 1].map(|i| optional(phase.walk_s.map(|both| both[i])));
    vec![
        plan.control.name().to_owned(),
        optional(plan.cycle_s),
        optional(plan.offset_s),
        reference.join(" "),
        plan.referenced_to.to_string(),
        phase.number.to_string(),
        phase.ring.to_string(),
        phase.barrier.to_string(),
        phase.position.to_string(),
        phase.movements.join(" "),
        phase.yielding.join(" "),
        number(phase.min_green_s),
        number(phase.max_green_s),
        number(rounded(phase.split_s())),
        number(phase.passage_s),
        number(phase.yellow_s),
        number(phase.all_red_s),
        walk_s,
        clearance_s,
        phase.recall.name().to_owned(),
        yes(phase.dual_entry),
        yes(phase.inhibit_max),
    ]
}

/// Returns plans as a table, which reads back as the same.
pub fn to_csv(plans: &[NamedPlan]) -> String {
    let header = ["intersection", "period"].into_iter().chain(WRITTEN);
    let mut rows: Vec<Vec<String>> = vec![header.map(str::to_owned).collect()];
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
    use super::super::testing::plan;
    use super::*;

    const HEADER: &str = "intersection,control,cycle_s,phase,ring,barrier,position,movements,yielding,split_s,yellow_s,all_red_s";
    const ROWS: &str =
        "7,pretimed,60,2,1,1,1,NBT NBR,NBL,30,4,1\n7,,,4,1,2,1,\"EBT, EBR\",ebl,30,4,1\n";

    #[test]
    fn a_plan_that_was_written_reads_back_as_the_same() {
        let mut plan = plan(Control::Coordinated);
        plan.phases[1].walk_s = Some([7.0, 14.5]);
        plan.phases[1].recall = Recall::Ped;
        plan.phases[2].inhibit_max = true;
        plan.offset_s = Some(12.5);
        let named =
            NamedPlan { intersection: "Oak / Main".into(), period: "am".into(), plan, line: 2 };
        let text = to_csv(std::slice::from_ref(&named));
        assert_eq!(read(&text, "e.csv").unwrap().all, std::slice::from_ref(&named));
        let computed = NamedPlan { intersection: "=1+1".into(), ..named };
        let text = to_csv(std::slice::from_ref(&computed));
        assert!(
            text.lines().nth(1).unwrap().starts_with("'=1+1,am,"),
            "no spreadsheet computes it"
        );
        assert_eq!(read(&text, "e.csv").unwrap().all, [computed]);
    }

    #[test]
    fn a_sheet_for_the_cabinet_is_read_if_it_is_of_one_plan() {
        let named = NamedPlan {
            intersection: "7".into(),
            period: String::new(),
            plan: plan(Control::Pretimed),
            line: 2,
        };
        let table = |methods: [&str; 2], replicates: [&str; 2]| {
            let header = WRITTEN.join(",");
            let mut text = format!("intersection,title,method,replicate,signal,kind,{header}\n");
            for (i, phase) in named.plan.phases.iter().enumerate() {
                let (method, replicate) = (methods[i / 3], replicates[i / 3]);
                let cells = cells(&named.plan, phase).join(",");
                text += &format!("7,Oak,{method},{replicate},c,phase,{cells}\n");
            }
            read(&text, "cabinet.csv")
        };
        assert_eq!(table(["nema"; 2], ["0"; 2]).unwrap().all, std::slice::from_ref(&named));
        let e = table(["existing", "nema"], ["0"; 2]).unwrap_err().to_string();
        assert!(e.contains("line 5: rows are of several methods (existing, nema); keep"), "{e}");
        let e = table(["idqn"; 2], ["0", "1"]).unwrap_err().to_string();
        assert!(e.contains("rows are of several trainings (0, 1)"), "{e}");
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
        let greens = plans.all[0].plan.phases.iter().map(|p| p.max_green_s);
        assert_eq!(greens.collect::<Vec<_>>(), [25.0, 25.0]);
        let e = read_it("30,4,1,25", "30,4,1,26").unwrap_err();
        assert!(e.contains("line 3: split_s = 30, but green, yellow and all-red are 31 s"), "{e}");
        let e = read_it("30,4,1,25", ",4,1,").unwrap_err();
        assert!(e.contains("line 3: split_s is empty; give a number"), "{e}");
    }

    #[test]
    fn few_columns_are_enough() {
        let plans = read(&format!("{HEADER}\n{ROWS}"), "e.csv").unwrap();
        let phase = &plans.all[0].plan.phases[1];
        assert_eq!(
            (&phase.movements[..], &phase.yielding[..]),
            (&["EBT".into(), "EBR".into()][..], &["EBL".into()][..])
        );
        assert_eq!((phase.max_green_s, phase.min_green_s, phase.passage_s), (25.0, 5.0, 3.0));
        assert!(phase.dual_entry);
    }
}
