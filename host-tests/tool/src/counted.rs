//! Numbers of things in texts.

use texts::counted;

counted! {
    /// Frames on a bus.
    Frames = "frame" "frames", "Frame" "Frames";
    /// Errors of a bus.
    Errors = "error" "errors", "Fehler" "Fehler";
    /// Samples.
    Samples = "sample" "samples", "Messwert" "Messwerte";
    /// All samples, after "of".
    OfSamples = "sample" "samples", "Messwert" "Messwerten";
    /// Lines of a file, or of an adapter.
    Lines = "line" "lines", "Zeile" "Zeilen";
    /// Entries of a data sheet.
    Entries = "entry" "entries", "Eintrag" "Einträge";
    /// Bytes.
    Bytes = "byte" "bytes", "Byte" "Bytes";
    /// Starts of a sensor.
    Starts = "start" "starts", "Start" "Starts";
    /// Saves of parameters.
    Saves = "save" "saves", "Speichervorgang" "Speichervorgänge";
    /// Erases of a memory.
    Erases = "erase" "erases", "Löschvorgang" "Löschvorgänge";
    /// Settings of a sensor.
    Settings = "setting" "settings", "Einstellung" "Einstellungen";
}
