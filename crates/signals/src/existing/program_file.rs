//! Programs of SUMO (`tlLogic` in additional files) as existing plans.
//!
//! - **Which signal.** The `id` is the intersection, as tables of existing plans call it. [`SIGNAL`], as files for generated
//!   networks have it, is the one intersection of a scenario that has no other.
//! - **Which link.** A state has a letter per link of the generated network, see [`link_order`](crate::network::lanes::link_order).
//! - **What is taken**: static and actuated programs, one per signal, as phases of one ring ([`ran`](super::ran)). Of the
//!   parameters `max-gap` is read. Programs that jump (`next`), switch by the clock (`WAUT`) or go dark are refused.
//!
//! [`SIGNAL`]: crate::network::plain::SIGNAL

use roxmltree::{Document, Node};
use sheet::Fault;

use super::Plans;
use crate::program::{ProgramKind, ProgramPhase, SignalProgram};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;

/// Letters of a state that a plan can have: green, yielding, yellow, red, red and yellow, stop and turn.
const LETTERS: &str = "GgyYrus";

/// A program of a signal.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedProgram {
    /// Line of its `tlLogic`.
    pub line: u64,
    /// The program; its signal is the intersection.
    pub program: SignalProgram,
}

/// Reads the programs of an additional file.
///
/// # Errors
///
/// [`FamilyError::Csv`] with file and line: XML that is not well-formed, a network, a program that no plan can say.
pub fn read(text: &str, file: &str) -> Result<Plans, FamilyError> {
    let wrong = |line: u32, message: String| at(file, Fault { line: line.into(), message });
    let document = Document::parse(text)
        .map_err(|e| wrong(e.pos().row, format!("not well-formed XML: {e}")))?;
    let line = |node: Node<'_, '_>| document.text_pos_at(node.range().start).row;
    let mut programs: Vec<NamedProgram> = Vec::new();
    for node in document.descendants() {
        let wrong = |message: String| wrong(line(node), message);
        match node.tag_name().name() {
            "net" => {
                return Err(wrong(
                    "a network of SUMO, whose links are not those of a generated one; its signals run with --sumocfg, as the \
                     method program"
                        .to_owned(),
                ));
            }
            "WAUT" => {
                return Err(wrong(
                    "WAUT changes programs by the clock; give each program in a file of its own, with --plan-file".to_owned(),
                ));
            }
            "tlLogic" => {
                let signal = node.attribute("id").unwrap_or_default();
                if programs.iter().any(|p| p.program.signal == signal) || signal.trim().is_empty() {
                    return Err(wrong(format!(
                        "the id of a tlLogic is {signal:?}; give each that of its intersection, and others of a signal in files \
                         of their own with --plan-file"
                    )));
                }
                let program =
                    program(node, signal).map_err(|e| wrong(format!("signal {signal}: {e}")))?;
                programs.push(NamedProgram { line: line(node).into(), program });
            }
            _ => {}
        }
    }
    if programs.is_empty() {
        let message = "XML without a tlLogic, no existing plan; give an additional file with the programs of signals, a table \
                       of phases, or UTDF";
        return Err(wrong(1, message.to_owned()));
    }
    Ok(Plans { file: file.to_owned(), programs, ..Plans::default() })
}

/// Returns an attribute that is a number of seconds.
fn number(node: Node<'_, '_>, name: &str) -> Result<Option<f64>, String> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.map(Some).ok_or_else(|| format!("{name} = {text:?}: expected a number of seconds"))
}

fn program(logic: Node<'_, '_>, signal: &str) -> Result<SignalProgram, String> {
    let kind = match logic.attribute("type") {
        None | Some("static") => ProgramKind::Static,
        Some("actuated") => ProgramKind::Actuated,
        Some(other) => {
            return Err(format!(
                "its program is of type {other:?}; static and actuated ones can be taken, others as a table of phases"
            ));
        }
    };
    let is_actuated = kind == ProgramKind::Actuated;
    let of = |name: &'static str| logic.children().filter(move |node| node.has_tag_name(name));
    let phases = of("phase").map(|node| phase(node, is_actuated)).collect::<Result<Vec<_>, _>>()?;
    let letters = phases.first().map(|phase| phase.state.len());
    if letters.is_none() || phases.iter().any(|phase| Some(phase.state.len()) != letters) {
        return Err("it has no phases, or states of different lengths; give each link one letter in every state".into());
    }
    let gap = of("param").find(|node| is_actuated && node.attribute("key") == Some("max-gap"));
    Ok(SignalProgram {
        offset_s: number(logic, "offset")?.unwrap_or_default(),
        max_gap_s: gap.map(|node| number(node, "value")).transpose()?.flatten(),
        ..SignalProgram::new(signal, kind, phases)
    })
}

fn phase(node: Node<'_, '_>, is_actuated: bool) -> Result<ProgramPhase, String> {
    let state = node.attribute("state").unwrap_or_default();
    if let Some(letter) = state.chars().find(|c| !LETTERS.contains(*c)) {
        return Err(format!(
            "state {state:?} has the letter {letter}; plans have those of {LETTERS} (a signal that is off or flashes has none)"
        ));
    }
    if node.attribute("next").is_some_and(|next| !next.trim().is_empty()) {
        return Err("a phase says which is next; give the phases as a table".into());
    }
    let duration_s = number(node, "duration")?.filter(|s| *s > 0.0);
    let duration_s = duration_s.ok_or("a phase without a duration above 0 s")?;
    let [min_s, max_s] = [number(node, "minDur")?, number(node, "maxDur")?];
    let shortest_s = min_s.filter(|_| is_actuated).unwrap_or(duration_s);
    let max_s = max_s.filter(|s| is_actuated && *s >= shortest_s);
    Ok(ProgramPhase { max_s, ..ProgramPhase::fixed(state, shortest_s) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(body: &str) -> String {
        read(&format!("<additional>\n{body}\n</additional>"), "a.xml").unwrap_err().to_string()
    }

    #[test]
    fn programs_are_read_with_their_lines() {
        let text = "<additional>\n  <tlLogic id='7' type='actuated' programID='a' offset='12'>\n    \
                    <param key='max-gap' value='2.5'/><param key='jam-threshold' value='30'/>\
                    <phase duration='20' minDur='5' maxDur='40' state='Gr'/><phase duration='4' state='yr'/>\n  </tlLogic>\n\
                    <vType id='v'><param key='other' value='1'/></vType>\
                    <tlLogic id='8' programID='0'><phase duration='9' state='G'/></tlLogic></additional>";
        let plans = read(text, "a.xml").unwrap();
        let [a, b] = &plans.programs[..] else { panic!("{plans:?}") };
        assert_eq!((a.line, a.program.offset_s, a.program.kind), (2, 12.0, ProgramKind::Actuated));
        assert_eq!((a.program.phases[0].duration_s, a.program.phases[0].max_s), (5.0, Some(40.0)));
        assert_eq!(a.program.max_gap_s, Some(2.5));
        assert_eq!((b.line, b.program.signal.as_str(), b.program.max_gap_s), (5, "8", None));
    }

    #[test]
    fn what_no_plan_can_say_is_refused_with_line_and_signal() {
        let phases = |phases: &str| refused(&format!("<tlLogic id='7'>\n{phases}</tlLogic>"));
        for (e, expected) in [
            (refused(""), "line 1: XML without a tlLogic, no existing plan"),
            (refused("<tlLogic id='7'><phase"), "not well-formed XML"),
            (refused("<tlLogic/>"), "line 2: the id of a tlLogic is \"\""),
            (refused("<tlLogic id='7' type='NEMA'/>"), "line 2: signal 7: its program is of type"),
            (refused("<tlLogic id='7'/>"), "line 2: signal 7: it has no phases"),
            (refused("<WAUT/>"), "WAUT changes programs by the clock"),
            (phases("<phase state='G'/>"), "signal 7: a phase without a duration above 0 s"),
            (phases("<phase duration='x' state='G'/>"), "duration = \"x\": expected a number"),
            (phases("<phase duration='9' state='Go'/>"), "has the letter o; plans have those"),
            (phases("<phase duration='9' state='G' next='0'/>"), "a phase says which is next"),
            (
                phases("<phase duration='9' state='G'/><phase duration='9' state='GG'/>"),
                "states of different lengths",
            ),
        ] {
            assert!(e.contains(expected), "{e}\n{expected}");
        }
        let e = read("<net><tlLogic id='7'/></net>", "n.net.xml").unwrap_err().to_string();
        assert!(e.contains("a network of SUMO, whose links are not those"), "{e}");
    }
}
