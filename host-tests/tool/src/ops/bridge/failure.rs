//! Why a connection has ended, and whether another try can succeed.

use super::address::Address;
use crate::error::{BrokerError, Error};
use rumqttc::{ConnectReturnCode, ConnectionError};
use rustls::{AlertDescription, CertificateError};
use std::error::Error as StdError;
use std::io;

/// The failure if no try can succeed: the user must change something.
pub fn lasting(error: &ConnectionError, address: &Address) -> Option<Error> {
    let url = address.to_string();
    let failure = match error {
        ConnectionError::ConnectionRefused(code) => match code {
            ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized => {
                BrokerError::Refused(url)
            }
            ConnectReturnCode::BadClientId => {
                BrokerError::RefusedClient(url, "its identifier".to_owned())
            }
            ConnectReturnCode::RefusedProtocolVersion => {
                BrokerError::RefusedClient(url, "MQTT 3.1.1".to_owned())
            }
            _ => return None,
        },
        ConnectionError::NotConnAck(_) => {
            BrokerError::RefusedClient(url, "its answer is not MQTT".to_owned())
        }
        _ => match tls(error)? {
            // The clock of a computer that has just started can be wrong.
            rustls::Error::InvalidCertificate(
                CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. },
            ) => return None,
            rustls::Error::InvalidCertificate(why) => BrokerError::Untrusted(url, why.to_string()),
            rustls::Error::InvalidMessage(_) => BrokerError::NotTls(url),
            rustls::Error::AlertReceived(alert) => refused(*alert, url)?,
            _ => return None,
        },
    };
    Some(failure.into())
}

/// The failure after an alert of the broker; None: the next try can succeed.
fn refused(alert: AlertDescription, url: String) -> Option<BrokerError> {
    let name = format!("{alert:?}");
    match alert {
        AlertDescription::NoCertificate
        | AlertDescription::BadCertificate
        | AlertDescription::UnsupportedCertificate
        | AlertDescription::CertificateRevoked
        | AlertDescription::CertificateExpired
        | AlertDescription::CertificateUnknown
        | AlertDescription::CertificateRequired
        | AlertDescription::UnknownCA
        | AlertDescription::AccessDenied
        | AlertDescription::DecryptError => Some(BrokerError::RefusedCertificate(url, name)),
        AlertDescription::UnrecognisedName => Some(BrokerError::RefusedName(url)),
        // A broker with TLS 1.2 that wants a certificate says HandshakeFailure.
        AlertDescription::HandshakeFailure
        | AlertDescription::ProtocolVersion
        | AlertDescription::InsufficientSecurity
        | AlertDescription::NoApplicationProtocol => Some(BrokerError::RefusedTls(url, name)),
        _ => None,
    }
}

/// The failure of TLS in an error, at any depth: a broker with TLS 1.3 refuses a certificate only when messages are read.
fn tls(error: &ConnectionError) -> Option<&rustls::Error> {
    let mut cause: Option<&(dyn StdError + 'static)> = Some(error);
    while let Some(own) = cause {
        if let Some(found) = own.downcast_ref() {
            return Some(found);
        }
        let inner = own.downcast_ref::<io::Error>().and_then(io::Error::get_ref);
        cause = match inner {
            Some(inner) => Some(inner),
            None => own.source(),
        };
    }
    None
}

/// The reason of a failure, for people.
pub fn reason(error: &ConnectionError) -> String {
    if let ConnectionError::NetworkTimeout = error {
        return "no answer".to_owned();
    }
    let mut innermost: &dyn StdError = error;
    while let Some(source) = innermost.source() {
        innermost = source;
    }
    match innermost.downcast_ref::<io::Error>() {
        Some(own) if own.kind() == io::ErrorKind::ConnectionAborted => {
            "the connection was closed".to_owned()
        }
        _ => innermost.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use rumqttc::{StateError, TlsError};

    #[test]
    fn alert_of_the_broker_tells_what_to_check() {
        let address = Address::parse("mqtts://broker").unwrap();
        for (alert, part) in [
            (AlertDescription::UnknownCA, Some("--certificate and --key")),
            (
                AlertDescription::CertificateRequired,
                Some("--certificate and --key"),
            ),
            (AlertDescription::ProtocolVersion, Some("TLS 1.2 or 1.3")),
            (AlertDescription::HandshakeFailure, Some("TLS 1.2 or 1.3")),
            (
                AlertDescription::UnrecognisedName,
                Some("check the address"),
            ),
            (AlertDescription::InternalError, None),
            (AlertDescription::UserCanceled, None),
        ] {
            let error = rustls::Error::AlertReceived(alert);
            let read = io::Error::new(io::ErrorKind::InvalidData, error.clone());
            for error in [
                ConnectionError::Tls(TlsError::TLS(error)),
                ConnectionError::MqttState(StateError::Io(read)),
            ] {
                let told = lasting(&error, &address).map(|error: Error| error.to_string());
                let is_right = match (&told, part) {
                    (Some(text), Some(part)) => text.contains(part),
                    (told, part) => told.is_none() && part.is_none(),
                };
                assert!(is_right, "{alert:?}: {told:?}");
            }
        }
    }
}
