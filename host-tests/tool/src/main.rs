//! The program `plumbline`: see `plumbline --help`.

use plumbline_tool::bar::TerminalBar;
use plumbline_tool::cli;
use plumbline_tool::command::run;
use plumbline_tool::error::{Error, FileError, RequestError};
use plumbline_tool::note::Note;
use plumbline_tool::output::Terminal;
use plumbline_tool::question::{Question, is_yes};
use std::io::{ErrorKind, IsTerminal, Write, stderr, stdin, stdout};
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::spawn;
use std::time::Duration;

/// Set when the user presses Ctrl-C.
static STOPPED: AtomicBool = AtomicBool::new(false);

/// The pause between two looks for Ctrl-C at a question.
const LOOK: Duration = Duration::from_millis(50);

fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    let cli = match cli::parse(&words) {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    // A second Ctrl-C ends the program at once.
    let caught = ctrlc::set_handler(|| {
        if STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    if let Err(error) = caught {
        print(
            &mut stderr(),
            &format!("plumbline: cannot catch Ctrl-C: {error}"),
        );
    }
    let json = cli.options.json;
    let (mut out, mut notes) = (stdout(), stderr());
    let mut terminal = Terminal {
        json,
        out: &mut out,
        notes: &mut notes,
        confirm: &mut asked,
        yes: &cli.options.yes,
        stopped: Rc::new(|| STOPPED.load(Ordering::Relaxed)),
        bar: TerminalBar::wanted(json),
    };
    let result = run(&cli, &mut terminal);
    terminal.hide();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::File(FileError::Closed(_))) => ExitCode::SUCCESS,
        Err(failure) => {
            if json && !matches!(failure, Error::AfterDocument(_)) {
                print(&mut stdout(), &failure.json().to_string());
            } else {
                print(&mut stderr(), &format!("plumbline: {failure}"));
                if ["no-answer", "nothing-found"].contains(&failure.code()) {
                    print(&mut stderr(), &Note::AllCauses.to_string());
                }
            }
            ExitCode::from(failure.kind().exit_code())
        }
    }
}

/// Reports an error in the command line, with `--json` as a document, or prints the text of `--help`.
fn usage(error: &clap::Error) -> ExitCode {
    let is_error = error.use_stderr();
    if is_error && std::env::args_os().any(|argument| argument == "--json") {
        let text = error.render().to_string();
        let text = text.trim_start_matches("error: ");
        let mut lines = text.lines().map(str::trim);
        let first = lines.next().unwrap_or(text).to_owned();
        // The name that the user has probably meant.
        let tip = lines.find_map(|line| line.strip_prefix("tip: "));
        let tip = tip.map_or(String::new(), |tip| format!("; {tip}"));
        let failure = Error::from(RequestError::Usage(first + &tip));
        print(&mut stdout(), &failure.json().to_string());
        return ExitCode::from(failure.kind().exit_code());
    }
    match error.print() {
        _ if is_error => ExitCode::from(2),
        Err(error) if error.kind() != ErrorKind::BrokenPipe => ExitCode::from(4),
        _ => ExitCode::SUCCESS,
    }
}

/// Asks a question on the terminal. Without a terminal the answer is no. Ctrl-C ends the question: the command then ends as at any other
/// place, with its last requests.
fn asked(question: &Question) -> bool {
    if !stdin().is_terminal() {
        let hint = question.name().map_or(String::new(), |name| {
            format!(", --yes={name} answers it with yes")
        });
        print(&mut stderr(), &format!("{question} [no terminal{hint}]"));
        return false;
    }
    let asked = write!(stderr(), "{question} [y/N] ");
    if asked.and_then(|()| stderr().flush()).is_err() {
        return false;
    }
    // The read cannot be ended, so another thread waits for it.
    let (sender, answers) = channel();
    spawn(move || {
        let mut answer = String::new();
        let read = stdin().read_line(&mut answer);
        let is_yes = read.is_ok() && is_yes(&answer);
        let _ = sender.send(is_yes);
    });
    loop {
        match answers.recv_timeout(LOOK) {
            Err(RecvTimeoutError::Timeout) if !STOPPED.load(Ordering::Relaxed) => {}
            Err(RecvTimeoutError::Timeout) => {
                print(&mut stderr(), "");
                return false;
            }
            answer => return answer.unwrap_or_default(),
        }
    }
}

/// Prints a line. An error is ignored, because there is no other output for it.
fn print(output: &mut dyn Write, line: &str) {
    let _ = writeln!(output, "{line}");
}
