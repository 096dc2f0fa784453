//! Programs of SUMO (`tlLogic` in additional files) as existing plans.
//!
//! - **Which signal.** The `id` is the intersection, as tables of existing plans call it. [`SIGNAL`], as files for generated
//!   networks have it, is the one intersection of a scenario that has no other.
//! - **Which link.** A state has a letter per link of the generated network, see [`link_order`](crate::network::lanes::link_order).
//! - **What is taken**: static and actuated programs, one per signal, as phases of one ring ([`ran`](super::ran)). Of the
//!   parameters `max-gap` is read, the others are told. Programs that jump (`next`), switch by the clock (`WAUT`) or go dark
//!   are refused.
//!
//! [`SIGNAL`]: crate::network::plain::SIGNAL

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use sheet::Fault;

use super::Plans;
use crate::program::{ProgramKind, ProgramPhase, SignalProgram};
use evaluation::family::columns::at;
use evaluation::family::error::FamilyError;

/// Letters of a state that a plan can have: green, yielding, yellow, red, red and yellow, stop and turn.
const LETTERS: &str = "GgyYrus";

/// Parameter of actuated programs: the gap between vehicles that ends a green, seconds.
const MAX_GAP: &str = "max-gap";

/// A program of a signal.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedProgram {
    /// Line of its `tlLogic`.
    pub line: u64,
    /// The program; its signal is the intersection.
    pub program: SignalProgram,
    /// Names of its parameters that are not read.
    pub unread: Vec<String>,
}

/// Reads the programs of an additional file.
///
/// # Errors
///
/// [`FamilyError::Csv`] with file and line: XML that is not well-formed, a network, a program that no plan can say.
pub fn read(text: &str, file: &str) -> Result<Plans, FamilyError> {
    let mut reader = Reader::from_str(text);
    let mut programs: Vec<NamedProgram> = Vec::new();
    let mut within = false;
    loop {
        let before = reader.buffer_position() as usize;
        let line = |position: usize| {
            let skipped =
                text.as_bytes()[position..].iter().take_while(|b| b.is_ascii_whitespace());
            let until = (position + skipped.count()).min(text.len());
            1 + text.as_bytes()[..until].iter().filter(|b| **b == b'\n').count() as u64
        };
        let line = line(before);
        let wrong = |message: String| at(file, Fault { line, message });
        let event = reader.read_event().map_err(|e| wrong(format!("not well-formed XML: {e}")))?;
        let tag = match &event {
            Event::Eof => break,
            Event::End(tag) => {
                within = within && !matches!(tag.name().as_ref(), "tlLogic");
                continue;
            }
            Event::Start(tag) | Event::Empty(tag) => tag,
            _ => continue,
        };
        match tag.name().as_ref() {
            "net" => {
                return Err(wrong(
                    "a network of SUMO, whose links are not those of a generated one; its signals run with --sumocfg, as \
                     the method program"
                        .to_owned(),
                ));
            }
            "WAUT" => {
                return Err(wrong(
                    "WAUT changes programs by the clock; give each program in a file of its own, with --plan-file"
                        .to_owned(),
                ));
            }
            "tlLogic" => {
                let program = logic(tag).map_err(wrong)?;
                let same = programs.iter().find(|p| p.program.signal == program.program.signal);
                if let Some(other) = same {
                    return Err(wrong(format!(
                        "signal {} has another program in line {}; give one, or each in a file of its own with --plan-file",
                        program.program.signal, other.line
                    )));
                }
                programs.push(NamedProgram { line, ..program });
                within = matches!(event, Event::Start(_));
            }
            "param" if within => {
                if let Some(program) = programs.last_mut() {
                    parameter(tag, program).map_err(wrong)?;
                }
            }
            "phase" => {
                let Some(program) = programs.last_mut() else {
                    return Err(wrong("a phase outside of a tlLogic".to_owned()));
                };
                let own = phase(tag, &program.program).map_err(wrong)?;
                program.program.phases.push(own);
            }
            _ => {}
        }
    }
    if programs.is_empty() {
        let message = "XML without a tlLogic, no existing plan; give an additional file with the programs of signals, a table \
                       of phases, or UTDF";
        return Err(at(file, Fault { line: 1, message: message.to_owned() }));
    }
    if let Some(empty) = programs.iter().find(|p| p.program.phases.is_empty()) {
        let message = format!("signal {} has no phases", empty.program.signal);
        return Err(at(file, Fault { line: empty.line, message }));
    }
    Ok(Plans { file: file.to_owned(), programs, ..Plans::default() })
}

/// Returns an attribute.
fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<Option<String>, String> {
    let not_xml = |e: &dyn std::fmt::Display| format!("not well-formed XML: {e}");
    let found = tag.try_get_attribute(name).map_err(|e| not_xml(&e))?;
    let value = found.map(|a| a.normalized_value(XmlVersion::Implicit1_0).map(|v| v.into_owned()));
    value.transpose().map_err(|e| not_xml(&e))
}

/// Returns an attribute that is a number of seconds.
fn number(tag: &BytesStart<'_>, name: &str) -> Result<Option<f64>, String> {
    let Some(text) = attribute(tag, name)? else { return Ok(None) };
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.map(Some).ok_or_else(|| format!("{name} = {text:?}: expected a number of seconds"))
}

/// Returns a program without phases.
fn logic(tag: &BytesStart<'_>) -> Result<NamedProgram, String> {
    let id = attribute(tag, "id")?.filter(|id| !id.trim().is_empty());
    let signal = id.ok_or("a tlLogic without an id; give it that of its intersection")?;
    let kind = match attribute(tag, "type")?.as_deref() {
        None | Some("static") => ProgramKind::Static,
        Some("actuated") => ProgramKind::Actuated,
        Some(other) => {
            return Err(format!(
                "signal {signal} has a program of type {other:?}; static and actuated ones can be taken, others as a table \
                 of phases"
            ));
        }
    };
    let offset_s = number(tag, "offset")?.unwrap_or_default();
    let program = SignalProgram { offset_s, ..SignalProgram::new(signal, kind, Vec::new()) };
    Ok(NamedProgram { line: 0, program, unread: Vec::new() })
}

/// Reads a parameter of a program.
fn parameter(tag: &BytesStart<'_>, named: &mut NamedProgram) -> Result<(), String> {
    let key = attribute(tag, "key")?.unwrap_or_default();
    let NamedProgram { program, unread, .. } = named;
    if key == MAX_GAP && program.kind == ProgramKind::Actuated {
        let gap_s = number(tag, "value");
        program.max_gap_s =
            gap_s.map_err(|e| format!("signal {}, {MAX_GAP}: {e}", program.signal))?;
    } else {
        unread.push(key);
    }
    Ok(())
}

/// Returns a phase of a program.
fn phase(tag: &BytesStart<'_>, program: &SignalProgram) -> Result<ProgramPhase, String> {
    let signal = &program.signal;
    let wrong = |message: String| format!("signal {signal}: {message}");
    let state = attribute(tag, "state")?.ok_or_else(|| wrong("a phase without a state".into()))?;
    let duration_s = number(tag, "duration")?.filter(|s| *s > 0.0);
    let duration_s =
        duration_s.ok_or_else(|| wrong("a phase without a duration above 0 s".into()))?;
    if let Some(letter) = state.chars().find(|c| !LETTERS.contains(*c)) {
        return Err(wrong(format!(
            "state {state:?} has the letter {letter}; plans have {} (a signal that is off or flashes has none)",
            LETTERS.chars().map(|c| c.to_string()).collect::<Vec<_>>().join(" ")
        )));
    }
    if attribute(tag, "next")?.is_some_and(|next| !next.trim().is_empty()) {
        return Err(wrong("a phase says which is next; give the phases as a table".into()));
    }
    if let Some(first) = program.phases.first().filter(|p| p.state.len() != state.len()) {
        return Err(wrong(format!(
            "states have {} and {} letters; give each link one letter in every state",
            first.state.len(),
            state.len()
        )));
    }
    let is_actuated = program.kind == ProgramKind::Actuated;
    let [min_s, max_s] = [number(tag, "minDur")?, number(tag, "maxDur")?];
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
        assert_eq!(
            (a.program.max_gap_s, &a.unread[..]),
            (Some(2.5), &["jam-threshold".to_owned()][..])
        );
        assert_eq!((b.line, b.program.signal.as_str()), (5, "8"));
        assert_eq!((b.program.max_gap_s, &b.unread[..]), (None, &[][..]));
    }

    #[test]
    fn what_no_plan_can_say_is_refused_with_line_and_signal() {
        let phase = |phase: &str| refused(&format!("<tlLogic id='7'>\n{phase}</tlLogic>"));
        for (e, expected) in [
            (refused(""), "line 1: XML without a tlLogic, no existing plan"),
            (refused("<tlLogic id='7'><phase"), "not well-formed XML"),
            (refused("<tlLogic/>"), "line 2: a tlLogic without an id"),
            (refused("<tlLogic id='7' type='NEMA'/>"), "signal 7 has a program of type \"NEMA\""),
            (refused("<tlLogic id='7' offset='x'/>"), "offset = \"x\": expected a number"),
            (
                refused(
                    "<tlLogic id='7' type='actuated'><param key='max-gap' value='x'/></tlLogic>",
                ),
                "signal 7, max-gap: value = \"x\": expected a number of seconds",
            ),
            (refused("<tlLogic id='7'/>"), "line 2: signal 7 has no phases"),
            (
                refused("<tlLogic id='7'/>\n<tlLogic id='7'/>"),
                "line 3: signal 7 has another program in line 2",
            ),
            (refused("<WAUT/>"), "WAUT changes programs by the clock"),
            (phase("<phase state='G'/>"), "line 3: signal 7: a phase without a duration above 0 s"),
            (phase("<phase duration='9' state='Go'/>"), "has the letter o; plans have G g y"),
            (phase("<phase duration='9' state='G' next='0'/>"), "a phase says which is next"),
            (
                phase("<phase duration='9' state='G'/><phase duration='9' state='GG'/>"),
                "states have 1 and 2 letters",
            ),
        ] {
            assert!(e.contains(expected), "{e}\n{expected}");
        }
        let e = read("<net><tlLogic id='7'/></net>", "n.net.xml").unwrap_err().to_string();
        assert!(e.contains("a network of SUMO, whose links are not those"), "{e}");
    }
}
