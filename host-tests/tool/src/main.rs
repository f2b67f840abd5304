//! The program `plumbline`: see `plumbline --help`.

use clap::Parser;
use plumbline_tool::cli::Cli;
use plumbline_tool::command::run;
use plumbline_tool::output::Terminal;
use std::io::{IsTerminal, Write, stderr, stdin, stdout};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ctrl-C was pressed.
static STOPPED: AtomicBool = AtomicBool::new(false);

fn main() -> ExitCode {
    let cli = Cli::parse();
    // A second Ctrl-C ends the program at once.
    let caught = ctrlc::set_handler(|| {
        if STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    if let Err(error) = caught {
        eprintln!("plumbline: cannot catch Ctrl-C: {error}");
    }
    let yes = cli.options.yes;
    let mut confirm = |question: &str| yes || (stdin().is_terminal() && asked(question));
    let json = cli.options.json;
    let (mut out, mut notes) = (stdout(), stderr());
    let mut terminal = Terminal {
        json,
        out: &mut out,
        notes: &mut notes,
        confirm: &mut confirm,
        stopped: &|| STOPPED.load(Ordering::Relaxed),
    };
    match run(&cli, &mut terminal) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if json {
                println!("{}", failure.json());
            } else {
                eprintln!("plumbline: {failure}");
            }
            ExitCode::from(failure.kind.exit_code())
        }
    }
}

/// Asks a question on the terminal.
fn asked(question: &str) -> bool {
    eprint!("{question} [y/N] ");
    let mut answer = String::new();
    let read = stderr()
        .flush()
        .and_then(|()| stdin().read_line(&mut answer));
    read.is_ok() && matches!(answer.trim(), "y" | "Y" | "yes")
}
