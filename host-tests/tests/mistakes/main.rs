//! Mistakes in the tables of a product are errors of the compiler at the macro of the table, without code generation, as in `cargo check`.
//! Their messages begin with the line of the row and name the row.

mod drivers;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

const CORE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../core");

/// The macro of each table, whose line the error shows.
const PARAMETERS: &str = "plumbline::project!(parameters);";
const OBJECTS: &str = "plumbline::project!(objects);";
const FUNCTIONS: &str = "plumbline::project!(functions);";
const ATTRIBUTES: &str = "plumbline::project!(attributes);";
const GROUPS: &str = "plumbline::project!(groups);";
/// The first line of the entry of the catalogue.
const LISTING: &str = r#"pub const LISTING: listing::Product = listing::Product::canopen::<Mast>(NAME, MAKER, ARTICLE)"#;

/// The message begins with the line that the mistake changes.
const CHANGED: Option<&str> = Some("");

/// A text of the product, another text in its place, the macro, the line of the row, and the message after it. The line is that of the
/// mistake, another one that begins with this text, or None: the mistake is not in a row.
type Mistake = (
    &'static str,
    &'static str,
    &'static str,
    Option<&'static str>,
    &'static str,
);

#[rustfmt::skip]
const CANOPEN: &[Mistake] = &[
    ("within(1, 100, 50)", "within(1, 100, 101)", PARAMETERS, CHANGED, "parameter 2 \"Limit\": the factory value must be permitted"),
    ("within(1, 100, 50)", "within(0, 255, 256)", PARAMETERS, CHANGED, "parameter 2 \"Limit\": the factory value must fit the type"),
    ("within(1, 100, 50)", "within(0, 255, -1)", PARAMETERS, CHANGED, "parameter 2 \"Limit\": the factory value must fit the type"),
    ("within(1, 100, 50)", "within(1, 256, 50)", PARAMETERS, CHANGED, "parameter 2 \"Limit\": the range must fit the type"),
    ("\"Limit\", DataType::U8).within(1, 100, 50)", "\"Limit\", DataType::U64)", PARAMETERS, CHANGED, "parameter 2 \"Limit\": a parameter of 64 bits has two rows"),
    ("profile::node_id(NODE_ID, 20),\n", "", PARAMETERS, Some("profile::bit_rate(BIT_RATE, 250)"), "parameter 0 \"Bit rate\": the id of a parameter must be its index"),
    ("[profile::device_type(0x0001_019A), ", "[", OBJECTS, None, "object 1000h:00: this object is mandatory in CiA 301"),
    (", profile::error_register()]", "]", OBJECTS, None, "object 1001h:00: this object is mandatory in CiA 301"),
    ("profile::identity(1, 2, 3),\n", "", OBJECTS, None, "object 1018h:00: this object is mandatory in CiA 301"),
    ("profile::bit_rate(BIT_RATE, 250),", "Parameter { permitted: Permitted::OneOf(&[250, 300]), ..profile::bit_rate(BIT_RATE, 250) },",
        OBJECTS, CHANGED, "parameter 1 \"Bit rate\": BIT_RATES has no bit rate for the permitted number 300"),
    ("const NODE_ID: ParameterId = NODE_ID;", "const NODE_ID: ParameterId = ParameterId(99);", OBJECTS, None, "NODE_ID: the table has no parameter 99"),
    ("const BIT_RATE: ParameterId = BIT_RATE;", "const BIT_RATE: ParameterId = ParameterId(7);", OBJECTS, None, "BIT_RATE: the table has no parameter 7"),
    ("Published<2>", "Published<1>", OBJECTS, Some("Quantity::new(RATE, \"Rate\", DataType::I32)"), "quantity 1: the application publishes fewer values"),
    ("ErrorHistory<2>", "ErrorHistory<3>", OBJECTS, Some("profile::error_history(2)"), "object 1003h:01: the dictionary has 2 errors, the capacity of the error history is 3"),
    ("Object::value(0x6011, 0, RATE)", "Object::value(0x6011, 0, ValueId(2))", OBJECTS, CHANGED, "object 6011h:00: the application has no quantity 2"),
    ("Object::parameter(0x2100, 0, LIMIT)", "Object::parameter(0x2100, 0, ParameterId(50))", OBJECTS, CHANGED, "object 2100h:00: the table has no parameter 50"),
    ("Object::parameter(0x2100, 0, LIMIT)", "Object::parameter(0x2100, 0, BIT_RATE)", OBJECTS, CHANGED, "object 2100h:00: this parameter is in two rows"),
    ("Object::parameter(0x2100, 0, LIMIT)", "Object::parameter(0x1F00, 0, LIMIT)", OBJECTS, CHANGED, "object 1F00h:00: rows must be sorted"),
    ("TpdoArray<1, 1>", "TpdoArray<2, 1>", OBJECTS, None, "object 1801h:01: the number of TPDOs is not that of the dictionary"),
    ("0x6010_0010", "0x6010_0020", OBJECTS, CHANGED, "object 1A00h:01: the mapped object 6010h:00 has another length"),
    ("0x6010_0010", "0x6012_0010", OBJECTS, CHANGED, "object 1A00h:01: the mapped object 6012h:00 does not exist"),
    ("type Consumers = Absent;", "type Consumers = plumbline::canopen::Heartbeats<1>;", OBJECTS, None, "object 1016h:01: the number of entries is not that of `Consumers`"),
    ("        Group::new(0x2000, 0x2000),\n        Group::new(0x2001, 0x5FFF),\n", "", OBJECTS, Some("profile::store(5)"), "object 1010h:04: there is no group of parameters for this sub-index"),
    ("0x180)", "0x080)", OBJECTS, Some("profile::tpdo(0, \"TPDO 1\", TPDO)"), "object 1800h:01: the default COB-ID is that of an EMCY"),
    ("0x180)", "0x580)", OBJECTS, Some("profile::tpdo(0, \"TPDO 1\", TPDO)"), "object 1800h:01: the default COB-ID is not free with the node-ID 1"),
    ("profile::error_history(2),", "", OBJECTS, None, "object 1003h:01: the dictionary has 0 errors, the capacity of the error history is 2"),
    (", profile::error_register()]", ", profile::constant(0x1001, 0, \"\", DataType::U8, 0)]", OBJECTS, CHANGED, "object 1001h:00: the error register is a service of the node"),
    ("Object::parameter(0x2100, 0, LIMIT)", "profile::service(0x2100, 0, \"Store\", DataType::U32, plumbline::canopen::dictionary::Access::Rw, SERVICE)",
        OBJECTS, CHANGED, "object 2100h:00: there is no group of parameters for this sub-index"),
    ("const GROUPS", "const EVENTS: &'static [FaultBit] = &[fault(\"passive\", Cause::Passive, 0x8120, 0)];\n    const GROUPS",
        OBJECTS, CHANGED, "event 0: its cause is `Overrun` or `BusOff`"),
    ("const GROUPS", "const EVENTS: &'static [FaultBit] = &[fault(\"lost\", Cause::Overrun, 0x8110, 0)];\n    const GROUPS",
        OBJECTS, CHANGED, "event 0: a bit of the status byte has this cause"),
    ("CIA_301[3]", "fault(\"lost\", Cause::Overrun, 0, 0)", OBJECTS, CHANGED, "fault 3: the emergency error code 0000h is the error reset"),
    ("CIA_301[3]", "fault(\"lost\", Cause::Memory, 0x6300, 0)", OBJECTS, CHANGED, "fault 3: another bit has this cause"),
    ("\"Slope\", DataType::I16)", "\"Slope\", DataType::I16).within(-18_000, 36_000)", OBJECTS, CHANGED, "quantity 0: the range must fit the type"),
    ("\"Limit\", DataType", "\"\", DataType", OBJECTS, Some("Object::parameter(0x2100, 0, LIMIT)"), "object 2100h:00: the object has no name"),
    ("            Object::parameter(0x2100, 0, LIMIT),\n", "            Object::parameter(0x2100, 1, LIMIT),\n", OBJECTS, CHANGED, "object 2100h:01: an object with sub-indices has sub-index 0"),
    ("const GROUPS", "const WRITABLE: usize = 64;\n    const GROUPS", OBJECTS, None, "WRITABLE: the buffer for texts is shorter"),
    ("const GROUPS", "const LSS_TABLES: &'static [LssTable] = &[LssTable::new(128, &[])];\n    const GROUPS", OBJECTS, CHANGED, "LSS_TABLES 0: a product without LSS has no table of bit rates"),
    ("DataType::U8).within(1, 100, 50)", "DataType::Real32).within(1, 100, 50).in_unit(\"deg\", 1)", PARAMETERS, CHANGED, "parameter 2 \"Limit\": a real number has its own decimal point: no decimals"),
    ("Object::value(0x6011, 0, RATE)", "Object::value(0xC011, 0, RATE)", OBJECTS, CHANGED, "object C011h:00: the index of an object is 1000h to BFFFh"),
    ("0x180)", "0x181)", OBJECTS, Some("profile::tpdo(0, \"TPDO 1\", TPDO)"), "object 1800h:01: the node-ID is added to the default COB-ID, which is without it, for example 180h"),
    ("0x180)", "0x600)", OBJECTS, Some("profile::tpdo(0, \"TPDO 1\", TPDO)"), "object 1800h:01: the default COB-ID is not free with the node-ID 1"),
    ("Group::new(0x2001, 0x5FFF)", "Group::new(0x1FFF, 0x5FFF)", OBJECTS, CHANGED, "GROUPS 1: a manufacturer-specific index is 2000h to 5FFFh"),
    ("Group::new(0x2001, 0x5FFF)", "Group::new(0x2000, 0x5FFF)", OBJECTS, CHANGED, "GROUPS 1: another group has some of these indices"),
    ("Group::new(0x2001, 0x5FFF),", "Group::new(0x2001, 0x2FFF),\n        Group::new(0x3000, 0x5FFF),", OBJECTS, CHANGED, "GROUPS 2: neither 1010h nor 1011h has a sub-index for this group"),
    ("\"Slope\", DataType::I16)", "\"Slope\", DataType::I16).in_unit(\"deg\", 10)", OBJECTS, CHANGED, "quantity 0: a number has at most 9 digits after the decimal point"),
    ("(0x2001, 0x5FFF)", "(0x3000, 0x5FFF)", OBJECTS, CHANGED, "GROUPS 1: no object of this group is a stored parameter"),
    ("(0x2001, 0x5FFF)", "(0x2100, 0x5FFF)", OBJECTS, Some("Object::parameter(0x2001, 0, BIT_RATE)"), "object 2001h:00: no group in `GROUPS` has this stored parameter"),
    ("            Object::value(0x6011, 0, RATE),\n", "", OBJECTS, Some("Quantity::new(RATE, \"Rate\", DataType::I32)"), "quantity 1: no object has this value"),
    ("Object::value(0x6011, 0, RATE)", "Object::value(0x6011, 0, SLOPE)", OBJECTS, Some("Quantity::new(RATE, \"Rate\", DataType::I32)"), "quantity 1: no object has this value"),
    ("profile::node_id(NODE_ID, 20)", "profile::lss_node_id(NODE_ID, 20)", OBJECTS, CHANGED, "parameter 0 \"Node-ID\": it permits 255, which is not a node-ID"),
];

#[rustfmt::skip]
const LISTINGS: &[Mistake] = &[
    ("(LIMIT, \"limit\")", "(ParameterId(9), \"limit\")", LISTING, None, "limit: the table has no parameter 9"),
    ("(\"limits\", &[LIMIT])", "(\"limits\", &[LIMIT, ParameterId(9)])", LISTING, None, "limits: the table has no parameter 9"),
    ("(LIMIT, \"limit\")", "(LIMIT, \"limit\"), (NODE_ID, \"limit\")", LISTING, None, "limit: two parameters have this short name"),
    ("(LIMIT, \"limit\")", "(LIMIT, \"\")", LISTING, None, "short_names: a name is empty"),
    ("(\"limits\", &[LIMIT])", "(\"limits\", &[LIMIT]), (\"limits\", &[LIMIT])", LISTING, None, "limits: two groups have this name"),
    ("name: \"MAST\"", "name: \"\"", LISTING, None, "article, name: the name is empty"),
    ("\"mast\"", "\"My Mast\"", LISTING, None, "name: a short name has the characters a to z, 0 to 9, `-` and `_`"),
    ("\"mast\"", "\"\"", LISTING, None, "name: the product has no short name"),
    ("\"Own\"", "\"\"", LISTING, None, "maker: the name is empty"),
    ("\"Own\"", "\"Own\\n\"", LISTING, None, "maker: the name has a line break"),
    ("angles: &[SLOPE]", "angles: &[SLOPE, ValueId(2)]", LISTING, None, "angles: the application has no quantity 2"),
    ("parameter: LIMIT", "parameter: ParameterId(9)", LISTING, None, "resolution: the table has no parameter 9"),
    ("parameters: &[LIMIT]", "parameters: &[ParameterId(9)]", LISTING, None, "resolution: the table has no parameter 9"),
    ("values: &[SLOPE]", "values: &[ValueId(2)]", LISTING, None, "resolution: the application has no quantity 2"),
    ("(LIMIT, Written::Nothing)", "(ParameterId(9), Written::Nothing)", LISTING, None, "zero 0: the table has no parameter 9"),
    ("Written::Nothing)])", "Written::Nothing)]).with_offset(listing::Offset { angle: ValueId(2), parameter: LIMIT, switch: None })", LISTING, None, "zero 0: the application has no quantity 2"),
    ("Written::Nothing)])", "Written::Nothing)]).with_offset(listing::Offset { angle: SLOPE, parameter: ParameterId(9), switch: None })", LISTING, None, "zero 0: the table has no parameter 9"),
    ("new(\"x\"", "new(\"X\"", LISTING, None, "zero 0: the axis is `x`, `y` or empty"),
    ("teach: &[]", "teach: &[Adjustment { absent_if: Some((ParameterId(9), 0)), ..Adjustment::new(\"\", &[]) }]", LISTING, None, "teach 0: the table has no parameter 9"),
];

#[rustfmt::skip]
const DYNAMIC: &[Mistake] = &[
    ("wide_within(-5, 1 << 40, -5)", "wide_within(-5, 1 << 40, -6)", PARAMETERS, CHANGED, "parameter 34 \"Total\": the factory value must be permitted"),
    ("DataType::I64).wide_within(-5", "DataType::U64).wide_within(-5", PARAMETERS, CHANGED, "parameter 34 \"Total\": the range must fit the type"),
    ("entry(0x6110, 0, 32)]", "entry(0x6110, 0, 32), entry(0x6110, 0, 32)]", OBJECTS, Some("profile::dynamic_mapping(0, \"Mapping 1\", MAPPING[0])"), "object 1A00h:00: the mapped objects do not fit into a frame"),
    ("entry(0x6010, 0, 16)", "entry(0x2000, 0, 8)", OBJECTS, Some("profile::dynamic_mapping(0, \"Mapping 1\", MAPPING[0])"), "object 1A00h:01: the mapped object 2000h:00 cannot be mapped"),
    ("entry(0x2200, 0, 64)]", "entry(0x2200, 0, 64), entry(0x6010, 0, 16)]", OBJECTS, Some("profile::dynamic_mapping(1, \"Mapping 2\", MAPPING[1])"), "object 1A01h:00: the mapped objects do not fit into a frame"),
    ("DynamicTpdos<2, 8>", "DynamicTpdos<2, 4>", OBJECTS, Some("profile::dynamic_mapping(0, \"Mapping 1\", MAPPING[0])"), "object 1A00h:05: the mapping has more entries than the TPDO takes"),
    ("MAPPING[1]),\n        [", "MAPPING[0]),\n        [", OBJECTS, CHANGED, "object 1A01h:00: this parameter is in two rows"),
    ("communication(TPDO[1], 0x280)", "communication(TPDO[1], 0x180)", OBJECTS, Some("profile::free_tpdo(1, \"TPDO 2\", TPDO[1])"), "object 1801h:01: another object has this default COB-ID"),
    ("Own::number(0x2300", "Own::number(0x2302", OBJECTS, Some("Object::own(0x2300, 0, \"Hours\", DataType::U16, Access::Ro)"), "object 2300h:00: `OWN` has no functions for this object"),
    ("Own::number(0x2300, 0, |_, _| 1)", "Own::command(0x2300, 0, |_, _| Ok(plumbline::canopen::Then::Reply))", OBJECTS, Some("Object::own(0x2300, 0, \"Hours\", DataType::U16, Access::Ro)"), "object 2300h:00: the access does not match its functions: `Own::number` or `Own::text`"),
    ("Own::number(0x2300, 0, |_, _| 1)", "Own::text(0x2300, 0, |_, _| Text::new())", OBJECTS, Some("Object::own(0x2300, 0, \"Hours\", DataType::U16, Access::Ro)"), "object 2300h:00: its function returns another type"),
    ("DataType::U16, Access::Ro", "DataType::U16, Access::Rw", OBJECTS, CHANGED, "object 2300h:00: the access does not match its functions"),
    ("DataType::U16, Access::Ro", "DataType::U64, Access::Ro", OBJECTS, CHANGED, "object 2300h:00: only a parameter or a value has 64 bits"),
    ("names: [\"MAST\"", "names: [\"\"", OBJECTS, Some("profile::standard(&PROFILE)"), "object 1008h:00: the text is empty"),
    ("names: [\"MAST\"", "names: [\"M\\u{e4}st\"", OBJECTS, Some("profile::standard(&PROFILE)"), "object 1008h:00: a text consists of printable ASCII characters"),
    ("Object::own(0x2301, 0, \"Reset\", DataType::U8, Access::Wo)", "Object { mappable: true, ..Object::own(0x2301, 0, \"Reset\", DataType::U8, Access::Wo) }",
        OBJECTS, CHANGED, "object 2301h:00: an object that cannot be read cannot be mapped"),
    ("DataType::U8, Access::Wo)", "DataType::U8, Access::Wo).starting(plumbline::canopen::dictionary::Command { starts: plumbline::canopen::dictionary::Starts::Other, numbers: \"\", limits: (1, 256) })",
        OBJECTS, CHANGED, "object 2301h:00: the limits of the command must fit the type"),
    ("profile::lss_node_id(NODE_ID, 50)", "Parameter { persistence: Persistence::Volatile, ..profile::lss_node_id(NODE_ID, 50) }", OBJECTS, CHANGED, "parameter 6 \"Node-ID\": a product with LSS stores node-ID and bit rate"),
    ("profile::bit_rate(BIT_RATE, 250)", "Parameter { persistence: Persistence::Volatile, ..profile::bit_rate(BIT_RATE, 250) }", OBJECTS, CHANGED, "parameter 7 \"Bit rate\": a product with LSS stores node-ID and bit rate"),
    ("LssTable::new(129,", "LssTable::new(127,", OBJECTS, CHANGED, "LSS_TABLES 1: the selector is 128 to 255"),
    ("LssTable::new(129,", "LssTable::new(128,", OBJECTS, CHANGED, "LSS_TABLES 1: another table has this selector"),
    ("Some(BitRate::K125)", "Some(BitRate::K62_5)", OBJECTS, CHANGED, "LSS_TABLES 0: the product does not permit the bit rate at index 1, 62.5 kbit/s: see BIT_RATES"),
    ("profile::free_tpdo(1, \"TPDO 2\", TPDO[1])", "{ let [a, _, c, d, e] = profile::free_tpdo(1, \"TPDO 2\", TPDO[1]); [a, Object::parameter(0x1801, 1, TPDO[1]), c, d, e] }",
        OBJECTS, CHANGED, "object 1801h:01: the COB-ID of a TPDO is `profile::cob_id` or `profile::free_cob_id`"),
    ("DynamicTpdos<2, 8>", "plumbline::canopen::TpdoArray<2, 8>", OBJECTS, Some("profile::dynamic_mapping(0, \"Mapping 1\", MAPPING[0])"), "object 1A00h:01: a mapping entry must be a constant, unless `Tpdos` is `DynamicTpdos`"),
    ("Quantity::new(SLOPE, \"Slope\", DataType::I16)", "Quantity { range: (1, 0), ..Quantity::new(SLOPE, \"Slope\", DataType::I16) }", OBJECTS, CHANGED, "quantity 0: the lowest number is above the highest one"),
    ("profile::lss_node_id(", "profile::node_id(", OBJECTS, CHANGED, "parameter 6 \"Node-ID\": a product with LSS permits the node-ID 255"),
];

#[rustfmt::skip]
const FSC: &[Mistake] = &[
    ("different(LIMIT, RECOVERY)", "different(LIMIT, ParameterId(99))", PARAMETERS, CHANGED, "constraint 0: the table has no parameter 99"),
    ("different(LIMIT, RECOVERY)", "different(RECOVERY, BIT_RATE)", PARAMETERS, CHANGED, "constraint 0: the factory values must fulfil the constraints"),
    ("parameter: CYCLIC_TIME", "parameter: ZERO", PARAMETERS, CHANGED, "constraint 1: both parameters are unsigned"),
    ("high: 500, other: CYCLIC_MODE, number: 1", "high: 99, other: CYCLIC_MODE, number: 0", PARAMETERS, CHANGED, "constraint 1: the factory values must fulfil the constraints"),
    ("0x18, 0x28", "0x18, 0x20", FUNCTIONS, CHANGED, "code 20h \"Zero and limit\": another row has this code"),
    ("&[ZERO, LIMIT]", "&[]", FUNCTIONS, CHANGED, "code 18h \"Zero and limit\": it reads no parameter"),
    ("&[ZERO, LIMIT]", "&[ZERO, ZERO]", FUNCTIONS, CHANGED, "code 18h \"Zero and limit\": it has a parameter twice"),
    ("&[ZERO, LIMIT]", "&[ZERO, TOTAL]", FUNCTIONS, CHANGED, "code 18h \"Zero and limit\": a field has at most 32 bits"),
    ("&[ZERO, LIMIT]", "&[ZERO, CYCLIC_TIME]", FUNCTIONS, CHANGED, "code 18h \"Zero and limit\": it writes parameters of the protocol and of the application"),
    ("&[ZERO, LIMIT]", "&[ZERO, ParameterId(40)]", FUNCTIONS, CHANGED, "code 18h \"Zero and limit\": the table has no parameter 40"),
    ("Source::Value(SLOPE)", "Source::Value(ValueId(2))", FUNCTIONS, Some("Function::new(0x00, \"Inclination\", Operation::Inclination).replying(&["), "code 00h \"Inclination\": the application has no quantity 2"),
    ("Field::described(Source::SerialNumber)", "Field::described(Source::SerialNumber), Field::described(Source::Value(FINE))",
        FUNCTIONS, Some("Function::new(0x04, \"Serial number\", Operation::Read)"), "code 04h \"Serial number\": its data has 8 bytes, a reply has room for 6"),
    ("Field::described(Source::Counter)", "Field::described(Source::Counter), Field::described(Source::Counter)",
        FUNCTIONS, Some("Function::new(0x00, \"Inclination\", Operation::Inclination).replying(&["), "code 00h \"Inclination\": the cyclic counter must be the last field"),
    ("\"Save\", Operation::Save", "\"Save\", Operation::Load", FUNCTIONS, CHANGED, "code 50h \"Save\": a product has one function with the operation Load"),
    ("\"Serial number\", Operation::Read", "\"Serial number\", Operation::Write", FUNCTIONS, CHANGED, "code 04h \"Serial number\": only the rows of ACCESS write parameters"),
    ("b\"RESET\"", "b\"\"", FUNCTIONS, CHANGED, "code FFh \"Alive\": without a signature, each request restarts the sensor"),
    (".signed(b\"LOAD\")", ".signed(b\"LOAD 1.0\")", FUNCTIONS, CHANGED, "code 40h \"Load\": a request has at most 7 bytes after the code"),
    ("\"Own\", Operation::Own)", "\"Own\", Operation::Own).signed(b\"OWN\")", FUNCTIONS, CHANGED, "code 60h \"Own\": only the operations Load, Save and Alive have a signature"),
    ("code: 0x60,\n        serve", "code: 0x61,\n        serve", FUNCTIONS, Some("Function::new(0x60, \"Own\", Operation::Own)"), "code 60h \"Own\": OWN has no function for this code"),
    ("Function::new(0x60, \"Own\", Operation::Own),", "", FUNCTIONS, None, "code 60h \"OWN\": FUNCTIONS has no code with an own operation for it"),
    // The groups need 240 rows, one too many: each has those from its first to its last code.
    ("Function::new(0x60, \"Own\", Operation::Own),", "Function::new(0x60, \"Own\", Operation::Own),
        spare(0x0F), spare(0x1F), spare(0x2F), spare(0x30), spare(0x3F), spare(0x4F), spare(0x5F), spare(0x6F),
        spare(0x70), spare(0x7F), spare(0x80), spare(0x8F), spare(0x90), spare(0x9F), spare(0xA0), spare(0xAF),
        spare(0xB0), spare(0xBF), spare(0xC0), spare(0xCF), spare(0xD0), spare(0xDF), spare(0xE0), spare(0xEE),",
        FUNCTIONS, None, "FUNCTIONS: there are too many codes"),
    ("sync_id: SYNC_ID", "sync_id: ParameterId(60)", FUNCTIONS, None, "ROLES: the table has no parameter 60"),
    ("0x7FF, factory", "0x800, factory", FUNCTIONS, Some("identifier(SET_ID, \"Set-ID\", 0x300)"), "parameter 0 \"Set-ID\": it permits a number that is no identifier"),
    ("\"Reply-ID\", 0x301", "\"Reply-ID\", 0x300", FUNCTIONS, CHANGED, "parameter 1 \"Reply-ID\": the identifiers of requests, replies and sync frames differ"),
    ("[None, Some(BitRate::K250)]", "[Some(BitRate::K250)]", FUNCTIONS, Some("Parameter::new(BIT_RATE, \"Bit rate\", DataType::U8).within(0, 1, 0)"), "parameter 3 \"Bit rate\": `bit_rates` has no row for the permitted number 1"),
    ("within(1, 1000, 100)", "within(0, 1000, 100)", FUNCTIONS, CHANGED, "parameter 5 \"Cyclic time\": the cyclic time permits 0 ms"),
    ("factory: 5,", "factory: 5,\n                persistence: plumbline::param::Persistence::AtOnce,", FUNCTIONS, Some("..Parameter::new(LIMIT, \"Limit\", DataType::U8)"), "parameter 8 \"Limit\": a parameter is stored on save, or never"),
    ("Fault(Faults::X)", "Fault(Faults::WARM_UP)", FUNCTIONS, Some("StatusBit::new(\"\", Condition::Fault(Faults::Y))"), "status bit 5: the faults must be in the order of their bits"),
    ("Fault(Faults::X)", "Fault(Faults::NONE)", FUNCTIONS, CHANGED, "status bit 4: it has exactly one fault"),
    ("(5, \"high\")", "(1, \"high\")", PARAMETERS, Some("..Parameter::new(LIMIT, \"Limit\", DataType::U8)"), "parameter 8 \"Limit\": a number has two names"),
    ("Published<2>", "Published<1>", FUNCTIONS, Some("Quantity::new(FINE, \"Fine\", DataType::I32)"), "quantity 1: the application publishes fewer values"),
];

#[rustfmt::skip]
const DEVICENET: &[Mistake] = &[
    ("new(0x72", "new(0x71", ATTRIBUTES, CHANGED, "class 65h, instance 1, attribute 71h: the attributes of an object must be sorted by number"),
    ("Source::Value(SLOPE))", "Source::Value(SLOPE)).settable()", ATTRIBUTES, CHANGED, "class 65h, instance 1, attribute 72h: only a parameter or an own attribute is settable"),
    ("Source::Value(FINE)", "Source::Value(ValueId(9))", ATTRIBUTES, CHANGED, "class 66h, instance 1, attribute 01h: the application has no quantity 9"),
    ("Source::Parameter(LIMIT)", "Source::Parameter(ParameterId(70))", ATTRIBUTES, CHANGED, "class 65h, instance 1, attribute 71h: the table has no parameter 70"),
    ("DataType::U8, 4)", "DataType::U8, 256)", ATTRIBUTES, CHANGED, "class 65h, instance 1, attribute 01h: the constant must fit its type"),
    ("Own(DataType::U8)", "Own(DataType::Text)", ATTRIBUTES, CHANGED, "class 65h, instance 1, attribute 73h: an attribute is a number"),
    ("Own(DataType::U8)", "Own(DataType::U64)", ATTRIBUTES, CHANGED, "class 65h, instance 1, attribute 73h: an attribute has at most 32 bits"),
    ("read_only(0x65, 0x73", "read_only(0x65, 0x74", ATTRIBUTES, Some("Attribute::new(0x73, \"Own\", Source::Own(DataType::U8))"), "class 65h, instance 1, attribute 73h: OWN has no functions for this attribute"),
    ("Source::Own(DataType::U8)", "Source::Value(FINE)", ATTRIBUTES, None, "class 65h, instance 1, attribute 73h: OBJECTS has no own attribute for these functions"),
    ("0x66,", "0x65,", ATTRIBUTES, CHANGED, "class 65h: another object has this class"),
    ("0x66,", "0x63,", ATTRIBUTES, CHANGED, "class 63h: the class of a vendor is 64h to C7h"),
    ("Object::new(0x66, \"Fine\", &[EXACT])", "Object { revision: 0, ..Object::new(0x66, \"Fine\", &[]) }", ATTRIBUTES, CHANGED, "class 66h: the revision of a class is 1 to 255"),
    ("[SLOPE, SLOPE]", "[SLOPE, FINE]", ATTRIBUTES, CHANGED, "assembly 2: its words have 16 bits"),
    ("[SLOPE, SLOPE]", "[SLOPE, ValueId(7)]", ATTRIBUTES, CHANGED, "assembly 2: the application has no quantity 7"),
    ("[SLOPE, SLOPE]", "[SLOPE, SLOPE, SLOPE, SLOPE, SLOPE]", ATTRIBUTES, CHANGED, "assembly 2: an assembly has one to four words"),
    ("new(2, \"Twice\"", "new(1, \"Twice\"", ATTRIBUTES, CHANGED, "assembly 1: another assembly has this instance"),
    ("new(2, \"Twice\"", "new(3, \"Twice\"", ATTRIBUTES, Some("byte(POLLED, \"Polled assembly\", 1, 2)"), "parameter 3 \"Polled assembly\": it must permit exactly the instances of ASSEMBLIES, see 2"),
    ("\"MAC ID\", 0, 63", "\"MAC ID\", 0, 64", ATTRIBUTES, CHANGED, "parameter 0 \"MAC ID\": the highest permitted number is 64, the protocol needs 63"),
    ("\"Baud rate\", 0, 2", "\"Baud rate\", 0, 1", ATTRIBUTES, CHANGED, "parameter 1 \"Baud rate\": the highest permitted number is 1, the protocol needs 2"),
    ("Parameter::new(id, name, DataType::U8)", "Parameter::new(id, name, DataType::U16)", ATTRIBUTES, Some("byte(MAC_ID, \"MAC ID\", 0, 63)"), "parameter 0 \"MAC ID\": a parameter of the protocol is a byte"),
    ("BitRate::K500", "BitRate::M1", ATTRIBUTES, None, "bit rate 2: DeviceNet has the bit rates 125, 250 and 500 kbit/s"),
    ("mac_id: MAC_ID", "mac_id: ParameterId(30)", ATTRIBUTES, None, "ROLES: the table has no parameter 30"),
    ("persistence: Persistence::AtOnce,", "", ATTRIBUTES, Some("byte(MAC_ID, \"MAC ID\", 0, 63)"), "parameter 0 \"MAC ID\": a parameter is stored when it is written, or never"),
    ("\"MAST 1\"", "\"MAST\"", ATTRIBUTES, None, "IDENTITY: a product name has 5 to 32 characters"),
    ("\"MAST 1\"", "\"MAST 0123456789 0123456789 012345\"", ATTRIBUTES, None, "IDENTITY: a product name has 5 to 32 characters"),
    ("product_code: 7", "product_code: 0", ATTRIBUTES, None, "IDENTITY: the product code is at least 1"),
    ("(1, 2)", "(1, 0)", ATTRIBUTES, None, "IDENTITY: the revision is 1 to 127, 1 to 255"),
    ("Published<2>", "Published<1>", ATTRIBUTES, Some("Quantity::new(FINE, \"Fine\", DataType::I32)"), "quantity 1: the application publishes fewer values"),
];

#[rustfmt::skip]
const J1939: &[Mistake] = &[
    ("sent(0xFF20,", "sent(0xFF22,", GROUPS, Some("Group::new(\"SLOPE\", 0xFF20, ANGLE)"), "group 65312 \"SLOPE\": SENT has another group in this place"),
    ("        sent(0xFF21, Setting::Constant(1000)),\n", "", GROUPS, Some("Group::new(\"AGE\", 0xFF21, AGE)"), "group 65313 \"AGE\": SENT has no row for this group"),
    ("[Timer; 2]", "[Timer; 1]", GROUPS, None, "Timers: each group in SENT needs a timer"),
    ("0xFF21", "0xEF21", GROUPS, CHANGED, "group 61217 \"AGE\": a group with this number (PF below F0h) is not sent to all nodes"),
    ("0xFF21", "0x2FF21", GROUPS, CHANGED, "group 196385 \"AGE\": the number has more than 17 bits"),
    ("0xFF21", "0xFF20", GROUPS, CHANGED, "group 65312 \"AGE\": another group has this number"),
    ("0xFF21", "0xFECA", GROUPS, CHANGED, "group 65226 \"AGE\": the protocol itself has this group"),
    ("3318, 0, 16", "3318, 50, 16", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Slope\": the signal does not fit into the frame"),
    ("3318, 0, 16", "3318, 0, 7", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Slope\": a value has 8 to 32 bits"),
    ("3323, 48, 2", "3323, 15, 2", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Quality\": another signal has some of its bits"),
    ("3323, 48, 2", "3318, 48, 2", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Quality\": another signal has this suspect parameter number"),
    ("3323, 48, 2", "524288, 48, 2", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Quality\": a suspect parameter number has 19 bits"),
    ("Merit(Source::Pitch)", "Merit(Source::Roll)", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Quality\": a figure of merit comes after its value"),
    ("(1, 500)", "(0, 500)", GROUPS, Some("Signal::new(\"Slope\", 3318, 0, 16, PITCH)"), "group 65312 \"SLOPE\", signal \"Slope\": the resolution is no fraction"),
    ("(1, 500)", "(1, 50_000_000)", GROUPS, Some("Signal::new(\"Slope\", 3318, 0, 16, PITCH)"), "group 65312 \"SLOPE\", signal \"Slope\": the resolution is too fine"),
    ("Parameter(RATE)", "Parameter(ParameterId(9))", GROUPS, Some("Group::new(\"SLOPE\", 0xFF20, ANGLE)"), "group 65312 \"SLOPE\": the table has no parameter 9"),
    ("within(0, 7, 3)", "within(0, 8, 3)", GROUPS, CHANGED, "parameter 2 \"Priority\": the number 8 is too large, the protocol has room for 7"),
    ("Constant(127)", "Constant(128)", GROUPS, None, "NAME, vehicle system: the number 128 is too large, the protocol has room for 127"),
    ("within(0, 2047, 2047)", "within(0, 2048, 2047)", GROUPS, CHANGED, "parameter 3 \"Manufacturer\": the number 2048 is too large"),
    ("within(0, 253, 0x90)", "within(0, 254, 0x90)", GROUPS, CHANGED, "parameter 0 \"Address\": the number 254 is too large"),
    ("ParameterId = ADDRESS", "ParameterId = ParameterId(7)", GROUPS, None, "ADDRESS: the table has no parameter 7"),
    ("\"Mast\"", "\"Mast*\"", GROUPS, None, "MODEL: the text has characters of ASCII without `*`"),
    ("\"Own\"", "\"0123456789 0123456789 0123456789 0123456789\"", GROUPS, None, "MAKE: the identification with MAKE and TYPE is longer than a message"),
    ("(3318, 12)", "(3318, 32)", GROUPS, CHANGED, "trouble code 0: a failure mode identifier has 5 bits"),
    ("(639, 2)", "(3318, 12)", GROUPS, Some("Trouble::new(3318, 12),"), "trouble code 1: another row has this trouble code"),
    ("Published<1>", "Published<0>", GROUPS, Some("const QUANTITIES: &'static [Quantity] = &[Quantity::new(SLOPE, \"Slope\", DataType::I16)];"), "quantity 0: the application publishes fewer values"),
    ("\"AGE\"", "\"SLOPE\"", GROUPS, CHANGED, "group 65313 \"SLOPE\": another group has this name"),
    ("\"AGE\"", "\"\"", GROUPS, CHANGED, "group 65313 \"\": a name in the database has up to 32 letters, digits and `_`"),
    ("\"Slope\", 3318", "\"Slope angle\", 3318", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Slope angle\": a name in the database has up to 32 letters, digits and `_`"),
    ("Contents::Latency", "Contents::Own { resolution: (1, 100), offset: i32::MIN, unit: \"\" }", GROUPS, CHANGED, "group 65313 \"AGE\", signal \"Latency\": the offset is too large for the resolution"),
    ("0, 16, PITCH", "0, 33, PITCH", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Slope\": a signal has at most 32 bits"),
    ("\"Quality\"", "\"Slope\"", GROUPS, CHANGED, "group 65312 \"SLOPE\", signal \"Slope\": another signal has this name"),
    ("Contents::Latency", "Contents::Own { resolution: (1, 0), offset: 0, unit: \"\" }", GROUPS, CHANGED, "group 65313 \"AGE\", signal \"Latency\": the resolution is no fraction"),
];

/// The directory of the compiled products.
fn directory() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

/// The directory with the compiled library and those on which it depends.
fn libraries() -> PathBuf {
    let test = env::current_exe().unwrap();
    test.parent().unwrap().to_owned()
}

/// The library `plumbline`: the newest one, because other builds leave theirs.
fn library(libraries: &Path) -> PathBuf {
    let files = fs::read_dir(libraries)
        .unwrap()
        .map(|file| file.unwrap().path());
    let is_own = |file: &PathBuf| {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        name.starts_with("libplumbline-") && name.ends_with(".rlib")
    };
    let changed = |file: &PathBuf| fs::metadata(file).unwrap().modified().unwrap();
    files.filter(is_own).max_by_key(changed).unwrap()
}

/// Compiles a product without code generation and without warnings. Returns the errors.
fn compile(name: &str, product: &str) -> String {
    let errors = compile_with(name, product, "--cap-lints=allow");
    assert!(errors.is_empty() || errors.contains("error"), "{errors}");
    errors
}

/// Compiles a program without code generation, with this option for lints. Returns errors and warnings.
fn compile_with(name: &str, product: &str, lints: &str) -> String {
    let directory = directory();
    let file = directory.join(format!("mistake_{name}.rs"));
    fs::write(&file, product).unwrap();
    let libraries = libraries();
    let output = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .current_dir(CORE)
        // The products include a file of core.
        .env("CARGO_MANIFEST_DIR", CORE)
        .args([
            "--edition=2024",
            "--crate-type=lib",
            "--emit=metadata",
            lints,
        ])
        .arg(format!("--out-dir={}", directory.display()))
        .arg(format!("-Ldependency={}", libraries.display()))
        .arg(format!(
            "--extern=plumbline={}",
            library(&libraries).display()
        ))
        .arg(&file)
        .output()
        .unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        output.status.success(),
        !errors.contains("error"),
        "{errors}"
    );
    errors
}

/// Compiles a product, then the same with each of its mistakes. The mistakes are modules of one crate: the compiler starts once for all of
/// them.
fn check(name: &str, product: &str, mistakes: &[Mistake]) {
    assert_eq!(compile(name, product), "", "without mistakes");
    let mut modules = String::new();
    for (number, (text, other, ..)) in mistakes.iter().enumerate() {
        assert!(product.contains(text), "{text}");
        let file = format!("mistake_{name}_{number}.rs");
        fs::write(directory().join(&file), product.replace(text, other)).unwrap();
        modules += &format!("#[path = {file:?}]\npub mod mistake_{number};\n");
    }
    let errors = compile(&format!("{name}_modules"), &modules);
    for (number, (text, other, table, row, message)) in mistakes.iter().enumerate() {
        let mistaken = product.replace(text, other);
        let file = format!("mistake_{name}_{number}.rs:");
        let errors: Vec<&str> = errors
            .split("\n\n")
            .filter(|error| error.starts_with("error[") && error.contains(&file))
            .collect();
        let told = errors
            .iter()
            .find_map(|error| error.strip_prefix("error[E0080]: evaluation panicked: "))
            .unwrap_or_else(|| panic!("{other}: {errors:?}"));
        let rest = match (row, line_told(&file, told)) {
            (None, None) => told,
            (Some(row), Some((line, rest))) => {
                let line = mistaken.lines().nth(line - 1).unwrap().trim();
                let is_changed = !product.lines().any(|other| other.trim() == line);
                let is_told = line.starts_with(row) && is_changed == row.is_empty();
                assert!(is_told, "{other}: {line}\n{errors:?}");
                rest
            }
            (_, line) => panic!("{other}: {line:?}\n{errors:?}"),
        };
        assert!(rest.starts_with(message), "{other}\n{message}\n{errors:?}");
        // The other tables also miss a missing parameter.
        let is_only = errors.len() == 1 || *table == PARAMETERS;
        assert!(is_only, "{other}: errors besides this one\n{errors:?}");
        let line = mistaken.lines().position(|line| line.trim() == *table);
        let place = format!("{file}{}:", 1 + line.unwrap());
        let is_at_table = errors.iter().any(|error| error.contains(&place));
        assert!(is_at_table, "{other}: {place}\n{errors:?}");
    }
}

/// The line of the product with which a message begins, and the text after it.
fn line_told<'a>(file: &str, message: &'a str) -> Option<(usize, &'a str)> {
    let (_, line) = message.split_once(file)?;
    let (line, rest) = line.split_once(": ")?;
    Some((line.parse().ok()?, rest))
}

#[test]
fn each_mistake_of_a_canopen_product_is_an_error_at_its_table_with_the_line_of_the_row() {
    check("canopen", include_str!("canopen.rs"), CANOPEN);
}

#[test]
fn each_mistake_of_a_listing_is_an_error_at_its_expression_that_names_the_entry() {
    check("listing", include_str!("canopen.rs"), LISTINGS);
}

#[test]
fn each_mistake_of_a_dynamic_mapping_is_an_error_at_its_table_with_the_line_of_the_row() {
    check(
        "dynamic",
        include_str!("../../../core/tests/wire/stranger/dynamic.rs"),
        DYNAMIC,
    );
}

#[test]
fn each_mistake_of_an_fsc_product_is_an_error_at_its_table_with_the_line_of_the_row() {
    check("fsc", include_str!("fsc.rs"), FSC);
}

#[test]
fn each_mistake_of_a_devicenet_product_is_an_error_at_its_table_with_the_line_of_the_row() {
    check("devicenet", include_str!("devicenet.rs"), DEVICENET);
}

#[test]
fn each_mistake_of_a_j1939_product_is_an_error_at_its_table_with_the_line_of_the_row() {
    check("j1939", include_str!("j1939.rs"), J1939);
}

#[test]
fn article_number_with_small_letters_does_not_compile() {
    let article = include_str!("../../../core/examples/new_article.rs");
    assert_eq!(compile("article", article), "");
    let mistaken = article.replacen("XX-00030-01", "xx-00030-01", 1);
    let errors = compile("article_mistaken", &mistaken);
    let message = "an article number has capital letters, dashes and digits";
    assert!(errors.contains(message), "{errors}");
}
