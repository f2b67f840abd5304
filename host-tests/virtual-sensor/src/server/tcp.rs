//! Clients on TCP: one thread accepts them; each has a thread that reads and one that writes.

use super::event::{Client, ClientId, Ended, Event, Events, Language};
use super::outbox::Outbox;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// A client that reads nothing for this time, while there is data for it, is dropped.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);

/// Accepts clients that speak slcan on `listener` as long as the server runs.
pub fn serve(listener: TcpListener, events: Events) -> io::Result<()> {
    accept(listener, events, Language::Slcan)
}

/// Accepts clients that speak this language on `listener` as long as the server runs.
pub fn accept(listener: TcpListener, events: Events, language: Language) -> io::Result<()> {
    let accept = move || {
        loop {
            let joined = listener
                .accept()
                .and_then(|(stream, _)| join(stream, &events, language));
            // A client that could not join (already disconnected, too many files or threads) must not stop the server from
            // accepting others. The pause limits the processor load during a permanent shortage.
            if joined.is_err() {
                thread::sleep(Duration::from_millis(10));
            }
        }
    };
    thread::Builder::new().name("accept".into()).spawn(accept)?;
    Ok(())
}

/// Starts the two threads of a client.
fn join(stream: TcpStream, events: &Events, language: Language) -> io::Result<()> {
    // Without it, answers wait for the delayed acknowledgement of the client: 44 ms instead of 0.6 ms.
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
    let id = ClientId::next();
    let outbox = Arc::new(Outbox::default());
    let (reader, writer) = (stream.try_clone()?, stream.try_clone()?);
    let client = Client::new(Arc::clone(&outbox), move || {
        // An error means that the client has already disconnected.
        let _ = stream.shutdown(Shutdown::Both);
    });
    thread::Builder::new()
        .name(format!("write {id}"))
        .spawn(move || write(writer, &outbox))?;
    let events = events.clone();
    thread::Builder::new()
        .name(format!("read {id}"))
        .spawn(move || {
            events.send(Event::Joined(id, client, language))?;
            session(reader, id, &events)
        })?;
    Ok(())
}

/// Passes on the input of the client until it stops sending.
fn session(mut stream: TcpStream, id: ClientId, events: &Events) -> Result<(), Ended> {
    let mut buffer = [0; 4096];
    loop {
        match stream.read(&mut buffer) {
            Ok(length @ 1..) => events.send(Event::Input(id, buffer[..length].to_vec()))?,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Ok(_) | Err(_) => return events.send(Event::Left(id)),
        }
    }
}

/// Writes the content of the outbox until it is closed and empty, then disconnects.
fn write(mut stream: TcpStream, outbox: &Outbox) {
    while let Some(bytes) = outbox.take() {
        if stream.write_all(&bytes).is_err() {
            outbox.close();
            break;
        }
    }
    // Wakes the reading thread; an error means that the client has already disconnected.
    let _ = stream.shutdown(Shutdown::Both);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_do_not_wait_for_acknowledgement_of_tcp() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("a socket");
        let _client = TcpStream::connect(address).expect("it listens");
        let (stream, _) = listener.accept().expect("it has connected");
        let same = stream.try_clone().expect("a socket");
        let (events, _receiver) = Events::channel();
        join(stream, &events, Language::Slcan).expect("threads");
        assert_eq!(same.nodelay().ok(), Some(true));
    }
}
