//! Why a connection has ended, and whether another try can succeed.

use super::address::Address;
use crate::error::{BrokerError, Error};
use rumqttc::{ConnectReturnCode, ConnectionError, StateError, TlsError};
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
        AlertDescription::CloseNotify
        | AlertDescription::UserCanceled
        | AlertDescription::InternalError => None,
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
        _ => Some(BrokerError::RefusedTls(url, name)),
    }
}

/// The failure of TLS in an error.
fn tls(error: &ConnectionError) -> Option<&rustls::Error> {
    let io = match error {
        ConnectionError::Tls(TlsError::TLS(own)) => return Some(own),
        ConnectionError::Tls(TlsError::Io(own)) | ConnectionError::Io(own) => own,
        ConnectionError::MqttState(StateError::Io(own)) => own,
        _ => return None,
    };
    io.get_ref()?.downcast_ref()
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
            let error = ConnectionError::Tls(TlsError::TLS(rustls::Error::AlertReceived(alert)));
            let told = lasting(&error, &address).map(|error: Error| error.to_string());
            let is_right = match (&told, part) {
                (Some(text), Some(part)) => text.contains(part),
                (told, part) => told.is_none() && part.is_none(),
            };
            assert!(is_right, "{alert:?}: {told:?}");
        }
    }
}
