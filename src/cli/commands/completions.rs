//! `skyshed completions`: what shells need to complete words, and the man page, from the definitions of the commands.

use clap::{Args, Command};

use crate::cli::args::words::{Words, one_of};
use crate::cli::failure::{Result, refusal};
use crate::cli::say;
use clap_complete::Shell;

/// What is written.
#[derive(Debug, Clone, Copy)]
enum Kind {
    For(Shell),
    Man,
}

const KINDS: Words<Kind> = &[
    ("bash", "Words for bash", Kind::For(Shell::Bash)),
    ("elvish", "Words for elvish", Kind::For(Shell::Elvish)),
    ("fish", "Words for fish", Kind::For(Shell::Fish)),
    ("powershell", "Words for PowerShell", Kind::For(Shell::PowerShell)),
    ("zsh", "Words for zsh", Kind::For(Shell::Zsh)),
    ("man", "The manual, for `man -l`", Kind::Man),
];

#[derive(Debug, Args)]
#[command(after_help = "Example: skyshed completions bash > /etc/bash_completion.d/skyshed")]
pub(in crate::cli) struct CompletionsArgs {
    /// The shell, or `man` for the manual
    #[arg(value_name = "SHELL", value_parser = one_of(KINDS))]
    kind: Kind,
}

impl CompletionsArgs {
    pub(in crate::cli) fn run(&self, mut program: Command) -> Result<()> {
        let mut text = Vec::new();
        match self.kind {
            Kind::For(shell) => clap_complete::generate(shell, &mut program, "skyshed", &mut text),
            Kind::Man => {
                manual(program, &mut text).map_err(|e| refusal(402, format!("cannot write the manual: {e}")))?
            }
        }
        say::plain_answer(&text)
    }
}

/// The manual of the program, and of each command after it.
fn manual(program: Command, text: &mut Vec<u8>) -> std::io::Result<()> {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    clap_mangen::Man::new(program.clone()).render(text)?;
    for command in program.get_subcommands() {
        clap_mangen::Man::new(command.clone()).render(text)?;
    }
    Ok(())
}
