//! Defects for a data sheet, to test that they are found.

use Check::{Rules, Sensor};

/// The check that finds a defect.
pub enum Check {
    /// The rules of CiA 306 and CiA 301.
    Rules,
    /// The comparison with the sensor; the rules do not find it.
    Sensor,
}

/// A defect: in a section, a text is replaced by another one.
pub struct Defect {
    pub what: &'static str,
    pub found_by: Check,
    section: &'static str,
    from: &'static str,
    to: &'static str,
}

const fn defect(
    found_by: Check,
    what: &'static str,
    section: &'static str,
    from: &'static str,
    to: &'static str,
) -> Defect {
    Defect {
        what,
        found_by,
        section,
        from,
        to,
    }
}

pub const DEFECTS: &[Defect] = &[
    defect(Rules, "no ObjectType", "1017", "ObjectType=0x7\r\n", ""),
    defect(Rules, "unknown DataType", "2000", "0x0005", "0x00A0"),
    defect(Rules, "ARRAY is a RECORD", "1003", "=0x8", "=0x9"),
    defect(Rules, "wrong sub-index 0", "1018sub0", "Value=4", "Value=3"),
    defect(Rules, "wide sub-index 0", "1010sub0", "0x0005", "0x0007"),
    defect(
        Rules,
        "default value of a command",
        "2046",
        "PDOMapping=0",
        "PDOMapping=0\r\nDefaultValue=2",
    ),
    defect(
        Rules,
        "COB-ID for one node",
        "1800sub1",
        "$NODEID+0x180",
        "0x18A",
    ),
    defect(
        Rules,
        "COB-ID with a wrong base",
        "1801sub1",
        "0x280",
        "0x380",
    ),
    defect(
        Rules,
        "SYNC with the node id",
        "1005",
        "=0x80",
        "=$NODEID+0x80",
    ),
    defect(
        Rules,
        "mapping of an object that cannot be mapped",
        "1A01sub1",
        "0x61100020",
        "0x40810010",
    ),
    defect(
        Rules,
        "mapped object lost its flag",
        "6010",
        "Mapping=1",
        "Mapping=0",
    ),
    defect(
        Rules,
        "mapping of an object that does not exist",
        "1A00sub2",
        "0x60200010",
        "0x60300010",
    ),
    defect(
        Rules,
        "mapping with a wrong length",
        "1A00sub1",
        "0x60100010",
        "0x60100020",
    ),
    defect(Rules, "no EDSVersion", "FileInfo", "EDSVersion=4.0\r\n", ""),
    defect(Rules, "duplicate object", "100D", "[100D]", "[100C]"),
    defect(
        Rules,
        "duplicate sub-index",
        "1018sub2",
        "[1018sub2]",
        "[1018sub1]",
    ),
    defect(
        Rules,
        "wrong count in a list",
        "OptionalObjects",
        "Objects=28",
        "Objects=27",
    ),
    defect(
        Rules,
        "listed twice",
        "OptionalObjects",
        "2=0x1005",
        "2=0x1003",
    ),
    defect(
        Rules,
        "in a wrong list",
        "ManufacturerObjects",
        "15=0x4081",
        "15=0x6131",
    ),
    defect(
        Rules,
        "wrong SubNumber",
        "1200",
        "SubNumber=3",
        "SubNumber=2",
    ),
    defect(
        Rules,
        "factory value beyond its limits",
        "2043",
        "Value=2",
        "Value=5",
    ),
    defect(
        Rules,
        "factory value not of its type",
        "100D",
        "Value=0",
        "Value=256",
    ),
    defect(
        Rules,
        "wrong number of TPDOs",
        "DeviceInfo",
        "NrOfTXPDO=2",
        "NrOfTXPDO=4",
    ),
    defect(
        Rules,
        "another vendor",
        "DeviceInfo",
        "0x6D666900",
        "0x0069666D",
    ),
    defect(Rules, "line end", "1001", "register\r\n", "register\n"),
    defect(Sensor, "wrong DataType", "1017", "0x0006", "0x0007"),
    defect(
        Sensor,
        "ro instead of rw",
        "6000",
        "AccessType=rw",
        "AccessType=ro",
    ),
    defect(
        Sensor,
        "rw instead of ro",
        "1001",
        "AccessType=ro",
        "AccessType=rw",
    ),
    defect(
        Sensor,
        "wrong factory value",
        "6000",
        "Value=10",
        "Value=100",
    ),
    defect(Sensor, "wrong text", "1008", "JN2101", "JN2100"),
    defect(
        Sensor,
        "limit too low",
        "2044",
        "HighLimit=3",
        "HighLimit=2",
    ),
];

impl Defect {
    /// The data sheet with this defect.
    pub fn plant(&self, text: &str) -> String {
        let head = format!("[{}]\r\n", self.section);
        let start = text.find(&head).expect("the section");
        let length = text[start..].find("\r\n\r\n").unwrap_or(text.len() - start);
        let (before, rest) = text.split_at(start);
        let (section, after) = rest.split_at(length);
        assert!(section.contains(self.from), "{}", self.what);
        let section = section.replacen(self.from, self.to, 1);
        [before, &section, after].concat()
    }
}
