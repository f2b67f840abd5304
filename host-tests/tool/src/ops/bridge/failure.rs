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
            rustls::Error::AlertReceived(AlertDescription::InternalError) => return None,
            rustls::Error::AlertReceived(alert) => {
                BrokerError::RefusedCertificate(url, format!("{alert:?}"))
            }
            _ => return None,
        },
    };
    Some(failure.into())
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
