//! Clients on TCP: a thread that accepts them, and for each a thread that reads and one that writes.

use super::outbox::Outbox;
use super::{Client, ClientId, Ended, Event, Events};
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// A client that takes nothing for this long, while there is something for it, is dropped.
const WRITE_TIMEOUT: Duration = Duration::from_secs(10);

/// Accepts clients on `listener` for as long as the server runs.
pub fn serve(listener: TcpListener, events: Events) -> io::Result<()> {
    let accept = move || {
        loop {
            let joined = listener
                .accept()
                .and_then(|(stream, _)| join(stream, &events));
            // One client that could not join (it has gone already, there are too many files or threads) is no reason to turn
            // the next one away. The pause keeps a lasting shortage from taking the whole processor.
            if joined.is_err() {
                thread::sleep(Duration::from_millis(10));
            }
        }
    };
    thread::Builder::new().name("accept".into()).spawn(accept)?;
    Ok(())
}

/// Starts the two threads of a client.
fn join(stream: TcpStream, events: &Events) -> io::Result<()> {
    // Without it, answers wait for the client's delayed acknowledgement: 44 ms instead of 0.6 ms.
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
    let id = ClientId::next();
    let outbox = Arc::new(Outbox::default());
    let (reader, writer) = (stream.try_clone()?, stream.try_clone()?);
    let client = Client::new(Arc::clone(&outbox), move || {
        // An error says that the client has hung up itself.
        let _ = stream.shutdown(Shutdown::Both);
    });
    thread::Builder::new()
        .name(format!("write {id}"))
        .spawn(move || write(writer, &outbox))?;
    let events = events.clone();
    thread::Builder::new()
        .name(format!("read {id}"))
        .spawn(move || session(reader, id, client, &events))?;
    Ok(())
}

/// Passes on what the client sends until it stops sending.
fn session(
    mut stream: TcpStream,
    id: ClientId,
    client: Client,
    events: &Events,
) -> Result<(), Ended> {
    events.send(Event::Joined(id, client))?;
    let mut buffer = [0; 4096];
    loop {
        match stream.read(&mut buffer) {
            Ok(length @ 1..) => events.send(Event::Input(id, buffer[..length].to_vec()))?,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Ok(_) | Err(_) => return events.send(Event::Left(id)),
        }
    }
}

/// Writes what is in the outbox until it is closed and empty, then hangs up.
fn write(mut stream: TcpStream, outbox: &Outbox) {
    while let Some(bytes) = outbox.take() {
        if stream.write_all(&bytes).is_err() {
            outbox.close();
            break;
        }
    }
    // Wakes the reading thread; an error says that the client has hung up itself.
    let _ = stream.shutdown(Shutdown::Both);
}
