//! Errors of the calibration of a unit.

use texts::errors;

errors! {
    /// What stops the calibration of a unit.
    CalibrationError {
        NeedsAnswers: Usage "needs-answers" = "each position needs its own answer: leave out --yes",
            "jede Lage braucht ihre eigene Antwort: Lassen Sie --yes weg";
        Invalid(why: String): Usage "bad-file" = "{why}; nothing was written", "{why}; nichts wurde geschrieben";
        Measurement(why: String): Usage "bad-file" = "{why}", "die Messung: {why}";
        Unread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline calibrate {path} -- COMMAND` measures, with the command that prints the log",
            "{path} lässt sich nicht lesen ({reason}): `plumbline calibrate {path} -- COMMAND` misst, mit dem Befehl, der das Protokoll ausgibt";
        OtherSerial(path: String, own: u32, serial: u32): Usage "wrong-file" = "{path} belongs to the unit with serial number {own}, not of {serial}: choose another file",
            "{path} gehört zur Einheit mit der Seriennummer {own}, nicht {serial}: Wählen Sie eine andere Datei";
        OtherElement(path: String, own: &'static str, part: &'static str): Usage "wrong-file" = "{path} is the measurement of a unit with {own}, not with {part}: choose another file",
            "{path} ist die Messung einer Einheit mit {own}, nicht mit {part}: Wählen Sie eine andere Datei";
        NoSerial: Usage "no-serial" = "the log and the measurement have no serial number: give it with --serial N",
            "Protokoll und Messung haben keine Seriennummer: Geben Sie sie mit --serial N an";
        SerialOfLog(path: String, own: u32): Usage "no-serial" = "{path} belongs to the unit with serial number {own}, but the log does not contain the serial number of its unit: start the log before the unit, or give --serial {own}",
            "{path} gehört zur Einheit mit der Seriennummer {own}, das Protokoll enthält aber nicht die Seriennummer seiner Einheit: Starten Sie das Protokoll vor der Einheit, oder geben Sie --serial {own} an";
        Stopped: Stopped "stopped" = "stopped: the measured positions are in the file. The same command continues with the other positions",
            "angehalten: Die gemessenen Lagen sind in der Datei. Derselbe Befehl fährt mit den anderen fort";
        Declined: Usage "not-confirmed" = "stopped: the measured positions are in the file. The same command continues with the other positions",
            "angehalten: Die gemessenen Lagen sind in der Datei. Derselbe Befehl fährt mit den anderen fort";
        UnknownElement: Usage "unknown-element" = "the measuring element of this unit is newer than this program: use the newest plumbline",
            "das Messelement dieser Einheit ist neuer als dieses Programm: Verwenden Sie das neueste plumbline";
        Changed(own: u32, serial: u32): Usage "wrong-unit" = "the serial number was {own} and is {serial} now: calibrate one unit at a time",
            "die Seriennummer war {own} und ist jetzt {serial}: Kalibrieren Sie eine Einheit nach der anderen";
        Unknown(serial: u32): Usage "wrong-unit" = "the log now contains the serial number {serial}, but the serial number of the earlier positions is unknown: begin with a new file, and with --serial {serial}",
            "das Protokoll enthält jetzt die Seriennummer {serial}, die der früheren Lagen ist aber unbekannt: Beginnen Sie mit einer neuen Datei und mit --serial {serial}";
        Silent: Silent "no-answer" = "no acceleration in the log for 10 s: look at the probe and the accelerometer, then repeat the command",
            "seit 10 s ist keine Beschleunigung im Protokoll: Prüfen Sie Debug-Adapter und Beschleunigungsmesser, und wiederholen Sie den Befehl";
        LogUnstarted(command: String, reason: String): Bus "no-log" = "cannot start `{command}` ({reason})", "`{command}` lässt sich nicht starten ({reason})";
        NoCommand(command: String): Bus "no-log" = "cannot start `{command}` (it is empty)", "`{command}` lässt sich nicht starten (er ist leer)";
        NoOutput(command: String): Bus "no-log" = "cannot start `{command}` (it has no output)", "`{command}` lässt sich nicht starten (er hat keine Ausgabe)";
        LogEnded: Bus "log-ended" = "the command of the log has ended: connect the probe, look at its messages, and repeat",
            "der Befehl des Protokolls hat geendet: Verbinden Sie den Debug-Adapter, lesen Sie dessen Meldungen, und wiederholen Sie";
        NoUnit: Usage "no-unit" = "there is no unit: start `plumbline serve --calibrate FILE -- COMMAND` with the command that prints its log",
            "es gibt keine Einheit: Starten Sie `plumbline serve --calibrate FILE -- COMMAND` mit dem Befehl, der ihr Protokoll ausgibt";
        Running: Usage "running" = "the calibration runs already: answer its question, or stop it",
            "die Kalibrierung läuft schon: Beantworten Sie ihre Frage, oder halten Sie sie an";
        OldQuestion: Usage "old-question" = "this question already has an answer: check the position that the page shows now",
            "diese Frage hat schon eine Antwort: Prüfen Sie die Lage, die die Seite jetzt zeigt";
        NoThread(reason: String): Bus "no-thread" = "{reason}", "der Computer kann keinen Thread starten: {reason}";
    }
}
