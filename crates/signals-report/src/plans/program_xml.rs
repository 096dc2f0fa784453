//! Programs as SUMO's additional files, which `sumo -a` takes.

use quick_xml::escape::escape;

use signals::program::{ProgramKind, SignalProgram};

/// Returns an additional file with the programs of a method; `None` where none is to be loaded.
///
/// # Arguments
///
/// * `own` — whether programs that are the network's own are written too, which is right where they
///   start at time 0.
/// * `comment` — lines that say what it is.
pub(super) fn additional(
    method: &str,
    programs: &[SignalProgram],
    own: bool,
    comment: &[String],
) -> Option<String> {
    let known = |p: &&SignalProgram| {
        !p.phases.is_empty() && p.kind != ProgramKind::Other && (own || !p.own)
    };
    let programs: Vec<_> = programs.iter().filter(known).collect();
    if programs.is_empty() {
        return None;
    }
    let mut text = self::comment(comment) + "<additional>\n";
    for program in programs {
        text += &format!(
            "    <tlLogic id=\"{}\" type=\"{}\" programID=\"{}\" offset=\"{}\">\n",
            escape(program.signal.as_str()),
            program.kind.name(),
            escape(method),
            program.offset_s,
        );
        if let Some(gap_s) = program.max_gap_s.filter(|_| !program.own) {
            text += &format!("        <param key=\"max-gap\" value=\"{gap_s}\"/>\n");
        }
        for phase in &program.phases {
            let bound = |name: &str, value: Option<f64>| {
                value.map_or_else(String::new, |v| format!(" {name}=\"{v}\""))
            };
            text += &format!(
                "        <phase duration=\"{}\"{}{} state=\"{}\"/>\n",
                phase.duration_s,
                bound("minDur", phase.min_s),
                bound("maxDur", phase.max_s),
                escape(phase.state.as_str()),
            );
        }
        text += "    </tlLogic>\n";
    }
    text += "</additional>\n";
    Some(text)
}

/// Returns lines as a comment of XML, in which no two hyphens follow one another.
pub(super) fn comment(lines: &[String]) -> String {
    let mut text = "<!--\n".to_owned();
    for line in lines {
        text += "    ";
        for letter in line.chars() {
            if letter == '-' && text.ends_with('-') {
                text.push(' ');
            }
            text.push(letter);
        }
        text.push('\n');
    }
    text + "-->\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use signals::program::ProgramPhase;

    fn program(own: bool) -> SignalProgram {
        let phase = |state: &str, duration_s, max_s: Option<f64>| ProgramPhase {
            min_s: max_s.map(|_| duration_s),
            max_s,
            ..ProgramPhase::fixed(state, duration_s)
        };
        let phases = vec![phase("Gr", 7.0, Some(50.0)), phase("yr", 3.0, None)];
        SignalProgram {
            own,
            max_gap_s: Some(2.5),
            ..SignalProgram::new("a&b", ProgramKind::Actuated, phases)
        }
    }

    #[test]
    fn a_program_becomes_a_tl_logic_with_what_bounds_its_phases() {
        let comment = ["what -- it is".to_owned()];
        insta::assert_snapshot!(additional("actuated", &[program(false)], false, &comment).unwrap(), @r#"
        <!--
            what - - it is
        -->
        <additional>
            <tlLogic id="a&amp;b" type="actuated" programID="actuated" offset="0">
                <param key="max-gap" value="2.5"/>
                <phase duration="7" minDur="7" maxDur="50" state="Gr"/>
                <phase duration="3" state="yr"/>
            </tlLogic>
        </additional>
        "#);
    }
}
