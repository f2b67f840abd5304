//! A client on a pseudoterminal, for programs that expect a serial port.
//!
//! The terminal stays open after a client closes it; the next client finds it raw and empty. When a client closes it, the sensor
//! continues to run.

use super::event::{Client, ClientId, Ended, Event, Events, Language};
use super::outbox::Outbox;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::{Errno, ioctl_fionbio, read, write};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};
use std::ffi::CString;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use std::{io, thread};

/// Polling interval for a closed terminal: the operating system does not report when it is opened.
const REOPEN_INTERVAL: Duration = Duration::from_millis(10);

/// How often a thread that waits for the client to read checks whether the session has ended.
const WRITE_INTERVAL: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 100_000_000,
};

/// Creates a pseudoterminal, serves its clients as long as the server runs, and returns its path.
pub fn serve(events: Events) -> io::Result<String> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    ioctl_fionbio(&master, true)?;
    let terminal = Terminal {
        path: ptsname(&master, Vec::new())?,
        master,
    };
    terminal.reset()?;
    let path = terminal.path.to_string_lossy().into_owned();
    thread::Builder::new()
        .name("terminal".into())
        .spawn(move || while session(&terminal, &events).is_ok() {})?;
    Ok(path)
}

struct Terminal {
    master: OwnedFd,
    /// The path that clients open.
    path: CString,
}

impl Terminal {
    /// Makes the terminal raw and discards output that a client has not read.
    fn reset(&self) -> rustix::io::Result<()> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let client_side = open(self.path.as_c_str(), flags, Mode::empty())?;
        let mut settings = tcgetattr(&client_side)?;
        settings.make_raw();
        tcsetattr(&client_side, OptionalActions::Now, &settings)?;
        tcflush(&client_side, QueueSelector::IFlush)
    }

    /// Waits until one of `wanted` is possible or the terminal is closed; returns which of these is true, or nothing after
    /// `timeout`.
    fn wait(&self, wanted: PollFlags, timeout: Option<&Timespec>) -> rustix::io::Result<PollFlags> {
        let mut fds = [PollFd::new(&self.master, wanted)];
        match poll(&mut fds, timeout) {
            Ok(_) => Ok(fds[0].revents()),
            Err(Errno::INTR) => Ok(PollFlags::empty()),
            Err(error) => Err(error),
        }
    }

    /// Waits until a client has sent something.
    fn wait_for_client(&self) {
        while !matches!(self.wait(PollFlags::IN, None), Ok(events) if events.contains(PollFlags::IN))
        {
            thread::sleep(REOPEN_INTERVAL);
        }
    }

    /// Passes on the input of the client until it closes the terminal or the session ends.
    fn read(&self, id: ClientId, events: &Events, over: &AtomicBool) -> Result<(), Ended> {
        let mut buffer = [0; 4096];
        while !over.load(Ordering::Acquire) {
            match read(&self.master, &mut buffer) {
                Ok(length @ 1..) => events.send(Event::Input(id, buffer[..length].to_vec()))?,
                Err(Errno::AGAIN | Errno::INTR) => {
                    if self.wait(PollFlags::IN, None).is_err() {
                        break;
                    }
                }
                // EIO: no client has it open.
                Ok(_) | Err(_) => break,
            }
        }
        Ok(())
    }

    /// Writes the content of the outbox until the session ends.
    fn write(&self, outbox: &Outbox, over: &AtomicBool) {
        while let Some(bytes) = outbox.take() {
            let mut rest = &bytes[..];
            while !rest.is_empty() {
                if over.load(Ordering::Acquire) {
                    return;
                }
                match write(&self.master, rest) {
                    Ok(length) => rest = &rest[length..],
                    Err(Errno::AGAIN) => {
                        // Closed: the reading thread ends the session.
                        if self.wait(PollFlags::OUT, Some(&WRITE_INTERVAL)).is_err() {
                            return;
                        }
                    }
                    Err(Errno::INTR) => {}
                    Err(_) => return,
                }
            }
        }
    }
}

/// Serves one client, from its first byte until it closes the terminal or is dropped.
fn session(terminal: &Terminal, events: &Events) -> Result<(), Ended> {
    terminal.wait_for_client();
    let id = ClientId::next();
    let outbox = Arc::new(Outbox::default());
    let over = Arc::new(AtomicBool::new(false));
    let client = Client::new(Arc::clone(&outbox), {
        let over = Arc::clone(&over);
        move || over.store(true, Ordering::Release)
    });
    events.send(Event::Joined(id, client, Language::Slcan))?;
    let result = thread::scope(|scope| {
        let writer = thread::Builder::new()
            .name(format!("write {id}"))
            .spawn_scoped(scope, || terminal.write(&outbox, &over));
        let result = match writer {
            Ok(_) => terminal.read(id, events, &over),
            Err(_) => Ok(()),
        };
        over.store(true, Ordering::Release);
        outbox.close();
        result
    });
    // If this fails, the terminal stays as the client left it; there is no better fallback.
    let _ = terminal.reset();
    events.send(Event::Left(id))?;
    result
}
