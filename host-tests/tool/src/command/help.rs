//! `completions` and `man`, which are made from the definition of the command line.

use crate::cli;
use crate::error::{Error, FileError, RequestError};
use crate::known::meant;
use crate::output::{Terminal, closed};
use clap_complete::Shell;
use clap_mangen::Man;
use std::path::Path;

/// Prints the completions for a shell.
///
/// # Errors
/// The output is closed.
pub fn completions(shell: Shell, terminal: &mut Terminal) -> Result<(), Error> {
    // The generator panics at an output that is closed.
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut cli::command(), "plumbline", &mut script);
    print(&script, terminal)
}

/// Prints the manual page of the program or of a command, or writes all of them into a folder.
///
/// # Errors
/// There is no such command, the folder cannot be written, or the output is closed.
pub fn man(
    command: Option<&str>,
    out: Option<&Path>,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let program = cli::command().disable_help_subcommand(true);
    if let Some(folder) = out {
        let written = std::fs::create_dir_all(folder)
            .and_then(|()| clap_mangen::generate_to(program, folder));
        let path = folder.display();
        written.map_err(|error| FileError::FolderUnwritten(path.to_string(), error.to_string()))?;
        return terminal.line(format!("man {path}/plumbline.1"));
    }
    let page = page(program, command)?;
    let mut text = Vec::new();
    let rendered = page.render(&mut text);
    rendered.map_err(closed)?;
    print(&text, terminal)
}

fn page(mut program: clap::Command, command: Option<&str>) -> Result<Man, Error> {
    // Gives the pages of the commands their names, as `plumbline-scan`.
    program.build();
    let Some(name) = command else {
        return Ok(Man::new(program));
    };
    let names = program.get_subcommands().map(clap::Command::get_name);
    let meant = meant(name, names);
    let found = program.find_subcommand(name).cloned();
    found
        .map(Man::new)
        .ok_or_else(|| RequestError::UnknownCommand(name.to_owned(), meant).into())
}

fn print(text: &[u8], terminal: &mut Terminal) -> Result<(), Error> {
    terminal.out.write_all(text).map_err(closed)
}
