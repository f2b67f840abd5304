//! Why a request to the virtual sensor is refused.

use texts::texts;

texts! {
    /// Why a request for a sensor is refused.
    Refused {
        Seconds(longest: f64) = "the seconds are 0 to {longest}", "die Sekunden sind 0 bis {longest}";
        Temperature(low: f64, high: f64) = "the temperature in degC is {low} to {high}", "die Temperatur in °C ist {low} bis {high}";
        Supply(low: f64, high: f64) = "the supply in V is {low} to {high}", "die Versorgung in V ist {low} bis {high}";
        Identifier(digits: String) = "{digits} is not an identifier: it has 3 or 8 hexadecimal digits",
            "{digits} ist kein Identifier: Er hat 3 oder 8 hexadezimale Ziffern";
        NothingSaved = "nothing was saved since the start of the program", "seit dem Start des Programms wurde nichts gespeichert";
        Off = "the sensor is off", "der Sensor ist ausgeschaltet";
        NotOfElement(fault: &'static str) = "the ADXL355 of the simulated board has no fault {fault}",
            "der ADXL355 der simulierten Platine hat den Fehler {fault} nicht";
        NotOnBus = "the sensor does not take part in the bus", "der Sensor nimmt nicht am Bus teil";
        OfAll = "this request is not for one sensor", "diese Anfrage ist nicht für einen Sensor";
        Tilt(x: f64, y: f64, why: String) = "{why}", "die Lage X = {x}°, Y = {y}° gibt es nicht";
        Scene(why: String) = "{why}", "diese Bewegung ist nicht möglich ({why})";
    }
}

impl From<Refused> for String {
    fn from(refused: Refused) -> Self {
        refused.to_string()
    }
}
