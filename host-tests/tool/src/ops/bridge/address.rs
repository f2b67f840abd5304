//! The address of a broker, and what a connection to it needs. Passwords and keys come from files only.

use crate::backup::{Unread, read_text};
use crate::error::{BrokerError, Error, Fault};
use bench::file::{LONGEST_TEXT, read};
use rumqttc::Transport;
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::{ClientConfig, RootCertStore};
use serde::Deserialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::sync::Arc;

/// The address of a broker.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Address {
    /// The name or the number of the computer.
    pub host: String,
    /// The TCP port.
    pub port: u16,
    /// The connection has TLS.
    pub has_tls: bool,
}

impl Address {
    /// Reads `mqtt://HOST[:PORT]` or `mqtts://HOST[:PORT]`.
    ///
    /// # Errors
    /// It is something else, or has a user.
    pub fn parse(url: &str) -> Result<Self, Error> {
        let wrong = || BrokerError::Url(url.to_owned());
        let (scheme, rest) = url.split_once("://").ok_or_else(wrong)?;
        let (has_tls, usual) = match scheme {
            "mqtt" => (false, 1883),
            "mqtts" => (true, 8883),
            _ => return Err(wrong().into()),
        };
        if rest.contains('@') {
            return Err(BrokerError::SecretInUrl.into());
        }
        let rest = rest.strip_suffix('/').unwrap_or(rest);
        // An IPv6 address has brackets.
        let end = match rest.starts_with('[') {
            true => rest.find(']').map(|end| end + 1).ok_or_else(wrong)?,
            false => rest.find(':').unwrap_or(rest.len()),
        };
        let (host, port) = rest.split_at(end);
        let port = match port.strip_prefix(':') {
            Some(port) => port.parse().ok().filter(|port| *port > 0),
            None => Some(usual).filter(|_| port.is_empty()),
        };
        let is_host = |host: &str| !host.is_empty() && !host.contains(['/', '?', '#', ' ']);
        match port {
            Some(port) if is_host(host) => Ok(Self {
                host: host.to_owned(),
                port,
                has_tls,
            }),
            _ => Err(wrong().into()),
        }
    }
}

impl Display for Address {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let scheme = if self.has_tls { "mqtts" } else { "mqtt" };
        write!(f, "{scheme}://{}:{}", self.host, self.port)
    }
}

/// User and password.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Credentials {
    pub(super) username: String,
    #[serde(default)]
    pub(super) password: String,
}

impl Credentials {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or is not valid. The message does not contain its text.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let name = path.display().to_string();
        let text = read_text(path).map_err(|why| {
            let reason = match why {
                Unread::Failed(error) => error.to_string(),
                Unread::Unfit(why) => Fault::from(why).to_string(),
            };
            BrokerError::Unread(name.clone(), reason)
        })?;
        toml::from_str(&text).map_err(|error: toml::de::Error| {
            // The message of the library has the value, which can be the password.
            let place = error.span().map_or(0, |span| span.start);
            let before = text.get(..place).unwrap_or_default();
            BrokerError::Credentials(name, before.matches('\n').count() + 1).into()
        })
    }
}

/// The files of a connection with TLS.
#[derive(Clone, Copy, Default)]
pub struct Files<'a> {
    /// The authority of the broker; None: those of this computer.
    pub ca: Option<&'a Path>,
    /// The certificate of this computer, and its key.
    pub own: Option<(&'a Path, &'a Path)>,
}

/// The connection to an address.
///
/// # Errors
/// A file cannot be read or is not valid, or is given without TLS.
pub fn transport(address: &Address, files: Files) -> Result<Transport, Error> {
    if !address.has_tls {
        return match files {
            Files { ca: Some(_), .. } => Err(BrokerError::OnlyTls("--ca").into()),
            Files { own: Some(_), .. } => Err(BrokerError::OnlyTls("--certificate").into()),
            _ => Ok(Transport::Tcp),
        };
    }
    let mut roots = RootCertStore::empty();
    match files.ca {
        Some(path) => {
            for certificate in certificates(path)? {
                let added = roots.add(certificate);
                added.map_err(|error| unfit(path, &error))?;
            }
        }
        None => {
            let found = rustls_native_certs::load_native_certs();
            let (added, _) = roots.add_parsable_certificates(found.certs);
            if added == 0 {
                let reason = found.errors.first().map(ToString::to_string);
                return Err(BrokerError::NoRoots(reason.unwrap_or_default()).into());
            }
        }
    }
    let builder = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions();
    let fits = |error: rustls::Error| Error::from(BrokerError::Tls(error.to_string()));
    let builder = builder.map_err(fits)?.with_root_certificates(roots);
    let config = match files.own {
        Some((certificate, key)) => {
            let chain = certificates(certificate)?;
            let bytes = read(key, LONGEST_TEXT).map_err(|error| unread(key, &error))?;
            let private = PrivateKeyDer::from_pem_slice(&bytes);
            let private = private.map_err(|error| unfit(key, &error))?;
            builder
                .with_client_auth_cert(chain, private)
                .map_err(fits)?
        }
        None => builder.with_no_client_auth(),
    };
    let config = rumqttc::TlsConfiguration::Rustls(Arc::new(config));
    Ok(Transport::Tls(config))
}

fn unread(path: &Path, error: &dyn Display) -> Error {
    BrokerError::Unread(path.display().to_string(), error.to_string()).into()
}

fn unfit(path: &Path, error: &dyn Display) -> Error {
    BrokerError::Certificate(path.display().to_string(), error.to_string()).into()
}

/// The certificates of a file, at least one.
fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, Error> {
    let bytes = read(path, LONGEST_TEXT).map_err(|error| unread(path, &error))?;
    let all = CertificateDer::pem_slice_iter(&bytes).collect::<Result<Vec<_>, _>>();
    let all = all.map_err(|error| unfit(path, &error))?;
    match all.is_empty() {
        true => Err(unfit(path, &"it has no certificate")),
        false => Ok(all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn address_has_host_port_and_tls() {
        for (url, shown) in [
            ("mqtt://broker", "mqtt://broker:1883"),
            ("mqtts://broker/", "mqtts://broker:8883"),
            ("mqtt://10.0.0.1:1884", "mqtt://10.0.0.1:1884"),
            ("mqtts://[fe80::1]:99", "mqtts://[fe80::1]:99"),
        ] {
            assert_eq!(Address::parse(url).unwrap().to_string(), shown);
        }
    }

    #[cfg(unix)]
    #[test]
    fn certificate_that_is_no_regular_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let address = Address::parse("mqtts://broker").unwrap();
        for path in [&pipe, Path::new("/dev/zero")] {
            let ca = Files {
                ca: Some(path),
                own: None,
            };
            let error = transport(&address, ca).err().unwrap();
            let text = error.to_string();
            assert!(text.contains("not a regular file"), "{text}");
        }
    }

    #[test]
    fn other_address_is_refused() {
        for (url, code) in [
            ("broker", "bad-url"),
            ("http://broker", "bad-url"),
            ("mqtt://", "bad-url"),
            ("mqtt://broker:0", "bad-url"),
            ("mqtt://broker:99999", "bad-url"),
            ("mqtt://broker/path", "bad-url"),
            ("mqtt://[fe80::1", "bad-url"),
            ("mqtt://user:secret@broker", "secret-in-url"),
        ] {
            let error = Address::parse(url).unwrap_err();
            assert_eq!(error.code(), code, "{url}");
            assert!(!error.to_string().contains("user:secret"), "{error}");
        }
    }
}
