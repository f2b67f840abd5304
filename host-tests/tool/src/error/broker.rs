//! Errors of a bridge to other programs.

use texts::errors;

errors! {
    /// What ends a bridge.
    BrokerError {
        NoDestination: Usage "no-destination" = "a bridge needs --mqtt or --agopengps", "eine Brücke braucht --mqtt oder --agopengps";
        Url(url: String): Usage "bad-url" = "{url:?} is not the address of an MQTT broker: write mqtt://HOST:1883, or mqtts://HOST:8883 with TLS",
            "{url:?} ist nicht die Adresse eines MQTT-Brokers: Schreiben Sie mqtt://HOST:1883, oder mqtts://HOST:8883 mit TLS";
        SecretInUrl: Usage "secret-in-url" = "the address of the broker has a user: other users of this computer can read it. Write user and password into a file, and give it with --credentials",
            "die Adresse des Brokers hat einen Benutzer: Andere Benutzer dieses Computers können ihn lesen. Schreiben Sie Benutzer und Passwort in eine Datei, und geben Sie sie mit --credentials an";
        OnlyTls(option: &'static str): Usage "no-tls" = "{option} is for a connection with TLS: write mqtts:// in place of mqtt://",
            "{option} ist für eine Verbindung mit TLS: Schreiben Sie mqtts:// statt mqtt://";
        Topic(option: &'static str, name: String): Usage "bad-topic" = "{option} {name:?} cannot be a part of a topic: it has 1 to 100 bytes, does not begin with $, and has no / + # or control character",
            "{option} {name:?} kann kein Teil eines Topics sein: Es hat 1 bis 100 Bytes, beginnt nicht mit $ und hat kein / + # oder Steuerzeichen";
        Unread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason})", "{path} lässt sich nicht lesen ({reason})";
        Credentials(path: String, line: usize): Usage "bad-file" = "{path} is not valid in line {line}. It has the lines username = \"NAME\" and password = \"PASSWORD\"",
            "{path} ist in Zeile {line} nicht gültig. Sie hat die Zeilen username = \"NAME\" und password = \"PASSWORT\"";
        Certificate(path: String, reason: String): Usage "bad-file" = "{path} is not valid: {reason}. It must be a file of the form PEM",
            "{path} ist nicht gültig: {reason}. Sie muss eine Datei der Form PEM sein";
        Tls(reason: String): Usage "bad-file" = "certificate and key do not fit: {reason}", "Zertifikat und Schlüssel passen nicht: {reason}";
        NoRoots(reason: String): Bus "no-file" = "this computer has no certificates of authorities ({reason}): give that of the broker with --ca",
            "dieser Computer hat keine Zertifikate von Zertifizierungsstellen ({reason}): Geben Sie das des Brokers mit --ca an";
        Refused(url: String): Bus "broker-refuses" = "{url} refuses user or password: check the file of --credentials",
            "{url} lehnt Benutzer oder Passwort ab: Prüfen Sie die Datei von --credentials";
        RefusedClient(url: String, reason: String): Bus "broker-refuses" = "{url} refuses this client ({reason}): check --site and --bus, and the settings of the broker",
            "{url} lehnt diesen Client ab ({reason}): Prüfen Sie --site und --bus und die Einstellungen des Brokers";
        Untrusted(url: String, reason: String): Bus "broker-untrusted" = "the certificate of {url} is not accepted ({reason}): check the address, and give the certificate of its authority with --ca",
            "das Zertifikat von {url} wird nicht angenommen ({reason}): Prüfen Sie die Adresse, und geben Sie das Zertifikat der Zertifizierungsstelle mit --ca an";
        RefusedCertificate(url: String, reason: String): Bus "broker-refuses" = "{url} does not accept the certificate of this computer ({reason}): check --certificate and --key",
            "{url} nimmt das Zertifikat dieses Computers nicht an ({reason}): Prüfen Sie --certificate und --key";
        RefusedName(url: String): Bus "broker-refuses" = "{url} has no certificate for this name: check the address", "{url} hat kein Zertifikat für diesen Namen: Prüfen Sie die Adresse";
        RefusedTls(url: String, reason: String): Bus "broker-refuses" = "{url} ends the start of TLS ({reason}): check that it offers TLS 1.2 or 1.3, and whether it wants a certificate with --certificate and --key",
            "{url} beendet den Beginn von TLS ({reason}): Prüfen Sie, ob er TLS 1.2 oder 1.3 anbietet und ob er ein Zertifikat mit --certificate und --key verlangt";
        NotTls(url: String): Bus "no-tls" = "{url} does not answer with TLS: check the port, often 8883, or write mqtt://",
            "{url} antwortet nicht mit TLS: Prüfen Sie den Port, oft 8883, oder schreiben Sie mqtt://";
        BufferInUse(path: String): Bus "buffer-in-use" = "another program uses {path}: end it, or choose another folder with --buffer",
            "ein anderes Programm verwendet {path}: Beenden Sie es, oder wählen Sie mit --buffer einen anderen Ordner";
        NoFolder: Usage "no-folder" = "this user has no folder for settings: give a folder with --buffer",
            "dieser Benutzer hat keinen Ordner für Einstellungen: Geben Sie mit --buffer einen Ordner an";
        Socket(address: String, reason: String): Bus "no-socket" = "cannot send to {address} ({reason})", "an {address} lässt sich nicht senden ({reason})";
        SeveralRolls(lines: String): Usage "several-sensors" = "several sensors are on the bus, and AgOpenGPS takes one roll ({lines}): name that of the roll by its address, for example --node 10",
            "mehrere Sensoren sind am Bus, und AgOpenGPS nimmt eine Rollneigung ({lines}): Nennen Sie deren Sensor mit seiner Adresse, zum Beispiel --node 10";
        NoRoll(sensor: String, axis: String, angles: String): Usage "no-axis" = "{sensor} has no angle {axis:?}: choose one of {angles} with --axis",
            "{sensor} hat keinen Winkel {axis:?}: Wählen Sie mit --axis einen von {angles}";
    }
}
