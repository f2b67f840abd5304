//! The virtual sensor as a process.

use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Time limit of a test step; much longer than it takes on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// The program, ready to be started.
pub fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_virtual-sensor"))
}

/// Runs it with arguments with which it must fail, and returns its output.
pub fn fails(arguments: &[&str]) -> Output {
    let mut child = program()
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let end = Instant::now() + PATIENCE;
    while child.try_wait().expect("a child").is_none() {
        if Instant::now() > end {
            child.kill().expect("a child");
            panic!("{arguments:?} did not exit");
        }
        thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().expect("its output")
}

/// A child that does not outlive its test.
pub struct Killed(pub Child);

impl Drop for Killed {
    fn drop(&mut self) {
        // Fails if it has already ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A running virtual sensor; it is killed when this is dropped.
pub struct Sensor {
    child: Killed,
    output: Receiver<String>,
    /// The port of 127.0.0.1 on which it listens.
    pub port: u16,
}

impl Sensor {
    /// Starts an IS2 with these additional arguments.
    pub fn start(arguments: &[&str]) -> Self {
        Self::start_with(arguments, &[])
    }

    /// The same with these variables of the environment.
    pub fn start_with(arguments: &[&str], environment: &[(&str, &str)]) -> Self {
        let mut child = program()
            .args(["--listen", "127.0.0.1:0"])
            .args(arguments)
            .envs(environment.iter().copied())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let (lines, output) = channel();
        let stdout = BufReader::new(child.stdout.take().expect("a pipe"));
        thread::spawn(move || {
            for line in stdout.lines().map_while(Result::ok) {
                if lines.send(line).is_err() {
                    break;
                }
            }
        });
        let mut sensor = Self {
            child: Killed(child),
            output,
            port: 0,
        };
        let line = sensor.line();
        sensor.port = line
            .strip_prefix("slcan socket://127.0.0.1:")
            .and_then(|port| port.parse().ok())
            .unwrap_or_else(|| panic!("the first line is {line:?}"));
        sensor
    }

    /// The next line on its standard output.
    pub fn line(&mut self) -> String {
        self.output.recv_timeout(PATIENCE).expect("a line")
    }

    /// The rest of its standard output; call it after its end.
    pub fn rest(&mut self) -> Vec<String> {
        self.output.iter().collect()
    }

    /// The address in the form of python-can.
    pub fn channel(&self) -> String {
        format!("socket://127.0.0.1:{}", self.port)
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        stream.set_nodelay(true).expect("a socket");
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        stream
    }

    /// Ends it like Ctrl-C and returns the exit code.
    #[cfg(unix)]
    pub fn interrupt(&mut self) -> Option<i32> {
        use rustix::process::{Pid, Signal, kill_process};
        kill_process(Pid::from_child(&self.child.0), Signal::INT).expect("it runs");
        self.exit_code()
    }

    /// Waits for its end and returns the exit code.
    pub fn exit_code(&mut self) -> Option<i32> {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(status) = self.child.0.try_wait().expect("a child") {
                return status.code();
            }
            assert!(Instant::now() < end, "it did not exit");
            thread::sleep(Duration::from_millis(2));
        }
    }

    /// Its standard error; call it once, after its end.
    pub fn errors(&mut self) -> String {
        let mut errors = String::new();
        let stderr = self.child.0.stderr.as_mut().expect("a pipe");
        stderr.read_to_string(&mut errors).expect("UTF-8");
        errors
    }

    /// Memory in use, in KiB.
    #[cfg(target_os = "linux")]
    pub fn memory(&self) -> u64 {
        let mut status = String::new();
        std::fs::File::open(format!("/proc/{}/status", self.child.0.id()))
            .and_then(|mut file| file.read_to_string(&mut status))
            .expect("the kernel reports it");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        line.and_then(|line| line.split_whitespace().next()?.parse().ok())
            .expect("VmRSS in kB")
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        if thread::panicking() {
            // Fails if it has already ended.
            let _ = self.child.0.kill();
            eprintln!("the virtual sensor's errors: {}", self.errors());
        }
    }
}
