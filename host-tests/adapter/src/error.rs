//! Errors of adapters and ports.

use texts::{errors, texts};

/// The ports that there can be.
const PORTS: &str = "ports are slcan://HOST:PORT, slcan:/dev/ttyACM0, can0 (Linux), usb[:SERIAL] and pcan[:USBBUS1]; `plumbline ports` lists those of this computer";
const PORTS_DE: &str = "Anschlüsse sind slcan://HOST:PORT, slcan:/dev/ttyACM0, can0 (Linux), usb[:SERIAL] und pcan[:USBBUS1]; `plumbline ports` nennt die dieses Computers";

errors! {
    /// What an adapter or its port refuses.
    AdapterError {
        NotOpen: Bus "not-open" = "the adapter only listens, so nothing was sent",
            "der Adapter hört nur, deshalb wurde nichts gesendet";
        Lost(name: String, reason: String): Bus "adapter-lost" = "the adapter {name} has failed ({reason}): plug it in again and repeat",
            "der Adapter {name} ist ausgefallen ({reason}): Stecken Sie ihn neu ein, und wiederholen Sie";
        ServerLost(name: String, reason: String): Bus "adapter-lost" = "the adapter {name} has failed ({reason}): is the server still running? Start it again and repeat",
            "der Adapter {name} ist ausgefallen ({reason}): Läuft der Server noch? Starten Sie ihn neu, und wiederholen Sie";
        InterfaceLost(name: String, reason: String): Bus "adapter-lost" = "the interface {name} has failed ({reason}): see `ip -details link show {name}`",
            "die Schnittstelle {name} ist ausgefallen ({reason}): siehe `ip -details link show {name}`";
        NoRate(name: String): Usage "no-rate" = "{name} needs a bit rate: give it with --rate (virtual-sensor: --bus-rate)",
            "{name} braucht eine Bitrate: Wählen Sie die Bitrate";
        NoListenOnly(name: String): Bus "no-listen-only" = "{name} has no listen-only mode, so it was not opened: `plumbline scan --active` sends requests without listening first",
            "{name} kann nicht nur hören und wurde nicht geöffnet: Kreuzen Sie Auch Anfragen senden an",
            "{name} has no listen-only mode, so it was not opened: check the box Send requests as well";
        SerialPort: Usage "unknown-port" = "slcan: needs a serial port, for example slcan:/dev/ttyACM0 or slcan:COM3; slcan://HOST:PORT is slcan over TCP",
            "slcan: braucht einen seriellen Anschluss, zum Beispiel slcan:/dev/ttyACM0 oder slcan:COM3; slcan://HOST:PORT ist slcan über TCP";
        Meant(port: String, meant: String): Usage "unknown-port" = "there is no port {port:?}: did you mean {meant}?",
            "es gibt keinen Anschluss {port:?}: Meinten Sie {meant}?";
        NoDriver(port: String): Usage "unknown-port" = "{port:?} has no port on this system, because there is no maintained Rust library for its driver: on Linux its port is can0. Here use an adapter of PEAK (pcan), with candleLight (usb) or with slcan (slcan:COM3)",
            "{port:?} hat auf diesem System keinen Anschluss, weil es für seinen Treiber keine gepflegte Rust-Bibliothek gibt: Unter Linux ist sein Anschluss can0. Verwenden Sie hier einen Adapter von PEAK (pcan), mit candleLight (usb) oder mit slcan (slcan:COM3)";
        UnknownPort(port: String): Usage "unknown-port" = "there is no port {port:?}: {PORTS}",
            "es gibt keinen Anschluss {port:?}: {PORTS_DE}";
        NoHost(port: String): Usage "unknown-port" = "{port:?} has no host or no valid port number: write slcan://HOST:PORT, for example slcan://127.0.0.1:11898",
            "{port:?} hat keinen Host oder keine gültige Portnummer: Schreiben Sie slcan://HOST:PORT, zum Beispiel slcan://127.0.0.1:11898";
        OnlyLinux(name: String): Usage "unknown-port" = "{name} can only be a CAN interface of Linux: {PORTS}",
            "{name} kann nur eine CAN-Schnittstelle von Linux sein: {PORTS_DE}";
        NoChannel(name: String, channels: u16): Usage "unknown-port" = "pcan has no channel {name:?}: write pcan:USBBUS1 to pcan:USBBUS{channels}, pcan:PCIBUS1 or pcan:LANBUS1",
            "pcan hat keinen Kanal {name:?}: Schreiben Sie pcan:USBBUS1 bis pcan:USBBUS{channels}, pcan:PCIBUS1 oder pcan:LANBUS1";
        NoLibrary(file: &'static str, hint: PcanHint): Bus "no-library" = "{file} was not found: {hint}",
            "{file} wurde nicht gefunden: {hint}";
        InUse(name: String): Bus "no-adapter" = "another program uses {name}: close it, for example PCAN-View",
            "ein anderes Programm verwendet {name}: Schließen Sie es, zum Beispiel PCAN-View";
        Missing(name: String, reason: String): Bus "no-adapter" = "there is no adapter {name} ({reason}): plug it in; `plumbline ports` lists the ports",
            "es gibt keinen Adapter {name} ({reason}): Stecken Sie ihn ein; `plumbline ports` nennt die Anschlüsse";
        Unopened(name: String, reason: String): Bus "no-adapter" = "cannot open {name} ({reason})",
            "{name} lässt sich nicht öffnen ({reason})";
        HasInterface(name: String): Bus "no-adapter" = "the driver of the kernel has this adapter as {name}: use the port {name}",
            "der Treiber des Kernels hat diesen Adapter als {name}: Verwenden Sie den Anschluss {name}";
        Several(ports: String): Bus "no-adapter" = "there are several adapters: choose one of {ports}",
            "es gibt mehrere Adapter: Wählen Sie einen von {ports}";
        NoUsb: Bus "no-adapter" = "there is no candleLight (gs_usb) adapter on USB: plug it in. An adapter that shows as a serial port has slcan: use slcan:PORT",
            "am USB gibt es keinen Adapter mit candleLight (gs_usb): Stecken Sie ihn ein. Ein Adapter, der als serieller Anschluss erscheint, hat slcan: Verwenden Sie slcan:PORT";
        OtherSerial(ports: String): Bus "no-adapter" = "there is no adapter with this serial number, but {ports}",
            "es gibt keinen Adapter mit dieser Seriennummer, aber {ports}";
        NoUsbList(reason: String): Bus "no-adapter" = "cannot list the devices on USB ({reason}): use a port that needs no USB, as slcan://HOST:PORT, or can0 on Linux",
            "die Geräte am USB lassen sich nicht auflisten ({reason}): Verwenden Sie einen Anschluss ohne USB, zum Beispiel slcan://HOST:PORT, oder unter Linux can0";
        UsbUnopened(name: String, reason: String, hint: UsbHint): Bus "no-adapter" = "cannot open {name} ({reason}): {hint}",
            "{name} lässt sich nicht öffnen ({reason}): {hint}";
        NotGsUsb(name: String): Bus "adapter-silent" = "{name} does not answer as a candleLight (gs_usb) adapter: update its firmware, or use another adapter",
            "{name} antwortet nicht wie ein Adapter mit candleLight (gs_usb): Aktualisieren Sie seine Firmware, oder verwenden Sie einen anderen Adapter";
        UsbUnclaimed(name: String, reason: String): Bus "no-adapter" = "cannot use {name} ({reason}): close other programs that use it. On Windows its driver must be WinUSB",
            "{name} lässt sich nicht verwenden ({reason}): Schließen Sie andere Programme, die ihn verwenden. Unter Windows muss sein Treiber WinUSB sein";
        NoTiming(name: String, rate: &'static str, clock: u32): Bus "rate-refused" = "{name} cannot have {rate} exactly with its clock of {clock} Hz: use another rate",
            "{name} kann mit seinem Takt von {clock} Hz nicht genau {rate} haben: Verwenden Sie eine andere Bitrate";
        RateRefused(name: String, rate: &'static str): Bus "rate-refused" = "{name} cannot have {rate}: use another rate",
            "{name} kann {rate} nicht haben: Verwenden Sie eine andere Bitrate";
        OpenRefused(name: String): Bus "adapter-refused" = "{name} does not open", "{name} öffnet sich nicht";
        NoSerial(path: String, reason: String): Bus "no-adapter" = "cannot open {path} ({reason}): this computer has no serial port: plug in the adapter",
            "{path} lässt sich nicht öffnen ({reason}): Dieser Computer hat keinen seriellen Anschluss: Stecken Sie den Adapter ein";
        OtherPorts(path: String, reason: String, ports: String): Bus "no-adapter" = "cannot open {path} ({reason}): the serial ports are {ports}",
            "{path} lässt sich nicht öffnen ({reason}): Die seriellen Anschlüsse sind {ports}";
        NotSlcan(name: String): Bus "adapter-silent" = "{name} does not answer like an slcan adapter: is it the port of the adapter (`plumbline ports`), and no other program has it open? Unplug it and plug it in again. CANable sticks with slcan firmware do not answer; use their candleLight firmware with the port usb or can0",
            "{name} antwortet nicht wie ein slcan-Adapter: Ist es der Anschluss des Adapters (`plumbline ports`), und hat ihn kein anderes Programm geöffnet? Stecken Sie ihn neu ein. CANable mit slcan-Firmware antworten nicht; verwenden Sie ihre candleLight-Firmware mit dem Anschluss usb oder can0";
        Foreign(name: String, text: String): Bus "no-adapter" = "{name} is not an slcan adapter: it sends {text:?}. Check the port; other ports are can0 and usb",
            "{name} ist kein slcan-Adapter: Er sendet {text:?}. Prüfen Sie den Anschluss; andere Anschlüsse sind can0 und usb";
        FrameRefused(name: String): Bus "frame-refused" = "{name} refused a frame, because its queue is full or the bus is off: check the bit rate and the wiring",
            "{name} hat ein Frame abgelehnt, weil seine Warteschlange voll oder der Bus aus ist: Prüfen Sie Bitrate und Verdrahtung";
        QueueFull: Bus "frame-refused" = "the queue of the interface is full, because no node acknowledges: check bit rate, wiring and terminators",
            "die Warteschlange der Schnittstelle ist voll, weil niemand bestätigt: Prüfen Sie Bitrate, Verdrahtung und Abschlusswiderstände";
        NoInterface(name: String): Bus "no-adapter" = "there is no interface {name}: `ip link` shows all, and other ports are slcan://HOST:PORT, slcan:/dev/ttyACM0 and usb[:SERIAL]",
            "es gibt keine Schnittstelle {name}: `ip link` zeigt alle, und andere Anschlüsse sind slcan://HOST:PORT, slcan:/dev/ttyACM0 und usb[:SERIAL]";
        NotCan(name: String): Bus "no-adapter" = "{name} is not a CAN interface: `plumbline ports` lists the ports of this computer",
            "{name} ist keine CAN-Schnittstelle: `plumbline ports` nennt die Anschlüsse dieses Computers";
        KindListens(name: String, kind: String): Bus "no-listen-only" = "the interface {name} ({kind}) has no listen-only mode that `ip` can set: it has the bit rate and the mode of the program that made it, for example slcand. Make it anew with these, or use the adapter directly, for example as the port slcan:/dev/ttyACM0",
            "die Schnittstelle {name} ({kind}) hat keine Betriebsart nur hören, die `ip` einstellen kann: Sie hat Bitrate und Betriebsart des Programms, das sie angelegt hat, zum Beispiel slcand. Legen Sie sie damit neu an, oder verwenden Sie den Adapter direkt, zum Beispiel mit dem Anschluss slcan:/dev/ttyACM0";
        NotListening(name: String, commands: String): Bus "no-listen-only" = "the interface {name} is not in listen-only mode. Type: {commands}",
            "die Schnittstelle {name} hört nicht nur. Geben Sie ein: {commands}";
        OnlyListens(name: String, commands: String): Bus "only-listens" = "the interface {name} only listens. Type: {commands}",
            "die Schnittstelle {name} hört nur. Geben Sie ein: {commands}";
        WrongRate(name: String, own: u32, rate: &'static str, commands: String): Bus "wrong-rate" = "the interface {name} has {own} bit/s, not {rate}. Type: {commands}",
            "die Schnittstelle {name} hat {own} bit/s, nicht {rate}. Geben Sie ein: {commands}";
        InterfaceUnopened(name: String, reason: String, commands: String): Bus "no-adapter" = "cannot open {name} ({reason}). Type: {commands}",
            "{name} lässt sich nicht öffnen ({reason}). Geben Sie ein: {commands}";
        NoConnection(address: String, reason: String): Bus "no-adapter" = "cannot connect to {address} ({reason}): is the adapter or the virtual sensor running there?",
            "keine Verbindung mit {address} ({reason}): Läuft dort der Adapter oder der virtuelle Sensor?";
    }
}

texts! {
    /// Where the library of PCAN comes from.
    PcanHint {
        Windows = "install PEAK's driver with PCAN-Basic", "Installieren Sie den Treiber von PEAK mit PCAN-Basic";
        MacOs = "install PCBUSB of mac-can.com", "Installieren Sie PCBUSB von mac-can.com";
        Linux = "install PEAK's driver with PCAN-Basic, or use the interface of the kernel (port can0), which needs no library",
            "Installieren Sie den Treiber von PEAK mit PCAN-Basic, oder verwenden Sie die Schnittstelle des Kernels (Anschluss can0), die keine Bibliothek braucht";
    }
}

texts! {
    /// Why an adapter on USB cannot be opened.
    UsbHint {
        Permission = "allow it with the udev rule in the README of plumbline, then plug it in again",
            "Erlauben Sie es mit der udev-Regel im README von plumbline, und stecken Sie ihn neu ein";
        Busy = "close other programs that use it", "Schließen Sie andere Programme, die ihn verwenden";
        Driver = "on Windows its driver must be WinUSB, see the README of plumbline",
            "Unter Windows muss sein Treiber WinUSB sein, siehe das README von plumbline";
        Other = "plug it in again, or use another port", "Stecken Sie ihn neu ein, oder verwenden Sie einen anderen Anschluss";
    }
}
