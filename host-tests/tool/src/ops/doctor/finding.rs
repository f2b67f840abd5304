//! What is wrong with a bus.

use crate::counted::{Errors, Frames};
use crate::error::Error;
use serde::{Serialize, Serializer};
use serde_json::json;
use texts::texts;

texts! {
    /// What is wrong, and what to do next.
    Finding {
        Silent = "no frame and no error was seen: check power and wiring of the sensors. A GEMAC sensor with factory values sends nothing by itself: `plumbline doctor --active` or `plumbline scan --active` sends requests to it",
            "kein Frame und kein Fehler: Prüfen Sie Versorgung und Verdrahtung der Sensoren. Ein GEMAC-Sensor wie geliefert sendet von selbst nichts: `plumbline doctor --active` oder `plumbline scan --active` fragt ihn";
        OnlyErrors(errors: Errors) = "{errors} and no valid frame at any bit rate: check for CAN_H and CAN_L exchanged or shorted, and whether two nodes have different bit rates; connect the nodes one after the other",
            "{errors} und kein gültiger Frame auf einer Bitrate: Prüfen Sie, ob CAN_H und CAN_L vertauscht oder kurzgeschlossen sind und ob zwei Knoten verschiedene Bitraten haben; schließen Sie die Knoten nacheinander an";
        WrongRate(given: &'static str, own: &'static str) = "the bus has {own}, not {given}: use --rate of the bus, or change the node with `plumbline rate`",
            "der Bus hat {own}, nicht {given}: Verwenden Sie die Bitrate des Busses, oder ändern Sie die des Knotens";
        Unacknowledged(id: String) = "no node acknowledges {id}, it is repeated continuously: its sender is alone on the bus. Connect and switch on a second node, check the wires between both and that both have the same bit rate",
            "niemand bestätigt {id}, er wird ständig wiederholt: Sein Sender ist allein am Bus. Schließen Sie einen zweiten Knoten an und schalten ihn ein, prüfen Sie die Leitung zwischen beiden und dass beide dieselbe Bitrate haben";
        NotTaken(errors: Errors) = "no node acknowledges the frames of the adapter ({errors}): no node is switched on at this bit rate, or a wire is broken. Check power and wires, and try another --rate",
            "niemand bestätigt die Frames des Adapters ({errors}): Auf dieser Bitrate ist kein Knoten eingeschaltet, oder eine Leitung ist unterbrochen. Prüfen Sie Versorgung und Leitungen, und versuchen Sie eine andere Bitrate";
        Disturbed(errors: Errors, frames: Frames) = "{errors} in {frames} of several identifiers: probably a terminator is missing. Switch the power off and measure 60 ohm between CAN_H and CAN_L (120 ohm: one is missing); then check shield, length of stubs and cables",
            "{errors} in {frames} mehrerer Identifier: Wahrscheinlich fehlt ein Abschlusswiderstand. Schalten Sie die Versorgung aus, und messen Sie 60 Ohm zwischen CAN_H und CAN_L (120 Ohm: einer fehlt); prüfen Sie dann Schirm, Länge der Stichleitungen und Kabel";
        OneDisturbed(id: String, errors: Errors) = "{errors}, nearly all before frames with {id}: two nodes send it, or its sender has a bad connection or another bit timing. Disconnect one node after the other until the errors end",
            "{errors}, fast alle vor Frames mit {id}: Zwei Knoten senden ihn, oder sein Sender hat eine schlechte Verbindung oder ein anderes Bit-Timing. Trennen Sie einen Knoten nach dem anderen, bis die Fehler enden";
        Doubled(id: String) = "two nodes seem to send {id}: its intervals alternate. Connect one of them alone and change its address",
            "zwei Knoten senden anscheinend {id}: Seine Abstände wechseln sich ab. Schließen Sie einen davon allein an, und geben Sie ihm eine andere Adresse";
        SameAddress(address: String) = "two nodes use the address {address}: connect one of them alone and change its address",
            "zwei Knoten verwenden die Adresse {address}: Schließen Sie einen davon allein an, und geben Sie ihm eine andere";
        Twins(told: Error) = "{told}", "{told}";
        Busy(load: f64) = "the bus load is {load} %: frames of low priority wait long. Make the periods longer, or use a higher bit rate",
            "die Buslast ist {load} %: Frames mit niedriger Priorität warten lange. Verlängern Sie die Perioden, oder verwenden Sie eine höhere Bitrate";
        Overruns(count: Frames) = "the adapter has lost at least {count}, so the figures are too low: close other programs, or use a faster adapter",
            "der Adapter hat mindestens {count} verloren, deshalb sind die Zahlen zu klein: Schließen Sie andere Programme, oder verwenden Sie einen schnelleren Adapter";
    }
}

impl Finding {
    /// The name for programs.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Silent => "silent",
            Self::OnlyErrors(_) => "only-errors",
            Self::WrongRate(..) => "wrong-rate",
            Self::Unacknowledged(_) | Self::NotTaken(_) => "nobody-acknowledges",
            Self::Disturbed(..) => "probable-missing-terminator",
            Self::OneDisturbed(..) => "errors-of-one-identifier",
            Self::Doubled(_) => "duplicate-identifier",
            Self::SameAddress(_) | Self::Twins(_) => "duplicate-address",
            Self::Busy(_) => "high-load",
            Self::Overruns(_) => "overruns",
        }
    }
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        json!({"code": self.code(), "message": self.to_string()}).serialize(to)
    }
}
