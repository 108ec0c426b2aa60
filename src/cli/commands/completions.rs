//! `skyshed completions`: completions for shells and the man page, from the definitions of the
//! commands.

use clap::{Args, Command};

use crate::cli::failure::{Result, refusal};
use crate::cli::say;
use clap_complete::Shell;
use skyshed_request::words::one_of;

skyshed_core::words! {
    /// Text to write.
    enum Kind {
        /// Words for bash
        Bash = "bash",
        /// Words for elvish
        Elvish = "elvish",
        /// Words for fish
        Fish = "fish",
        /// Words for PowerShell
        PowerShell = "powershell",
        /// Words for zsh
        Zsh = "zsh",
        /// The manual, for `man -l`
        Man = "man",
    }
}

#[derive(Debug, Args)]
#[command(after_help = "Example: skyshed completions bash > /etc/bash_completion.d/skyshed")]
pub(in crate::cli) struct CompletionsArgs {
    /// The shell, or `man` for the manual
    #[arg(value_name = "SHELL", value_parser = one_of::<Kind>())]
    kind: Kind,
}

impl CompletionsArgs {
    pub(in crate::cli) fn run(&self, mut program: Command) -> Result<()> {
        let mut text = Vec::new();
        let shell = match self.kind {
            Kind::Bash => Some(Shell::Bash),
            Kind::Elvish => Some(Shell::Elvish),
            Kind::Fish => Some(Shell::Fish),
            Kind::PowerShell => Some(Shell::PowerShell),
            Kind::Zsh => Some(Shell::Zsh),
            Kind::Man => None,
        };
        match shell {
            Some(shell) => clap_complete::generate(shell, &mut program, "skyshed", &mut text),
            None => manual(program, &mut text).map_err(|e| refusal(402, format!("cannot write the manual: {e}")))?,
        }
        say::plain_answer(&text)
    }
}

/// Writes the manual of the program, then the manual of each command.
fn manual(program: Command, text: &mut Vec<u8>) -> std::io::Result<()> {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    clap_mangen::Man::new(program.clone()).render(text)?;
    for command in program.get_subcommands() {
        clap_mangen::Man::new(command.clone()).render(text)?;
    }
    Ok(())
}
