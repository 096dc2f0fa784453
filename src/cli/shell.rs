//! `tsc-family completions` and `tsc-family man`: made at run time from the command line's types.

use clap::CommandFactory;

use super::{Cli, CompletionsArgs};
use crate::exit;

pub(super) fn completions(args: &CompletionsArgs) -> anyhow::Result<u8> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "tsc-family", &mut script);
    print(&script)
}

pub(super) fn man() -> anyhow::Result<u8> {
    let mut page = Vec::new();
    let command = Cli::command();
    clap_mangen::Man::new(command.clone()).render(&mut page)?;
    for subcommand in command.get_subcommands().filter(|c| !c.is_hide_set()) {
        let mut text = Vec::new();
        let man = clap_mangen::Man::new(subcommand.clone());
        man.render_description_section(&mut text)?;
        man.render_options_section(&mut text)?;
        let heading = format!(".SH COMMAND {}\n", subcommand.get_name().to_uppercase());
        page.extend_from_slice(heading.as_bytes());
        let text = String::from_utf8_lossy(&text).replace(".SH ", ".SS ");
        page.extend_from_slice(text.as_bytes());
    }
    print(&page)
}

fn print(text: &[u8]) -> anyhow::Result<u8> {
    use std::io::Write;
    std::io::stdout().write_all(text)?;
    Ok(exit::DONE)
}
