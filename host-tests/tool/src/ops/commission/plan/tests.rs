//! Tests of plans.

use super::*;

/// The line and the text of the fault of a plan.
fn fault(text: &str) -> (usize, String) {
    let (place, why) = Plan::parse(text, None).map(|_| ()).unwrap_err();
    (text[..place].matches('\n').count() + 1, why.to_string())
}

const ONE: &str = "[[sensor]]\nname = \"one\"\nproduct = \"jn2101\"\n";

#[test]
fn plan_has_sensors_of_several_products() {
    let text = format!(
        "{ONE}serial = 7\nparameters.node-id = 11\n[[sensor]]\nname = \"two\"\nproduct = \"IS2\"\nzero = true\n[sensor.parameters]\ncyclic-time = \"0.25 s\"\n"
    );
    let plan = Plan::parse(&text, None).unwrap_or_else(|why| panic!("{why:?}"));
    let [one, two] = &plan.sensors[..] else {
        panic!("{plan:?}");
    };
    assert_eq!((one.serial, one.zero), (Some(7), false));
    assert_eq!(
        one.target().map(|own| own.named()).as_deref(),
        Some("node-ID 11")
    );
    assert_eq!((two.serial, two.zero), (None, true));
    let texts: Vec<String> = two
        .settings
        .values
        .iter()
        .map(|(entry, raw)| two.settings.text_of(entry, *raw))
        .collect();
    assert_eq!(texts, ["250 ms"]);
}

#[test]
fn fault_of_a_plan_has_line_and_reason() {
    let again = |more: &str| format!("{ONE}parameters.node-id = 11\n[[sensor]]\n{more}");
    for (text, line, reason) in [
        (String::new(), 1, "has no sensor"),
        ("[[sensor]]\nname = \"a\"\n".to_owned(), 1, "product"),
        (
            "[[sensor]]\nname = \"\"\nproduct = \"is2\"\n".to_owned(),
            2,
            "name",
        ),
        (
            format!("{ONE}colour = 1\n"),
            4,
            "unknown field `colour`, expected one of `name`, `product`, `serial`, `find`, `zero`, `parameters`",
        ),
        (format!("{ONE}serial = -1\n"), 4, "-1"),
        (ONE.replace("jn2101", "jn21"), 3, "there is no product"),
        (
            format!("{ONE}[sensor.parameters]\nnode-id = 200\n"),
            5,
            "node-id",
        ),
        (
            format!("{ONE}[sensor.parameters]\nno-such = 1\n"),
            5,
            "no-such",
        ),
        (
            format!("{ONE}[sensor.parameters]\nnode-id = [1]\n"),
            5,
            "quotes",
        ),
        (again("name = \"one\"\nproduct = \"is2\"\n"), 6, "twice"),
        (
            again("name = \"two\"\nproduct = \"jn2101\"\nparameters.node-id = 11\n"),
            5,
            "same address as one",
        ),
        (
            format!(
                "{ONE}[[sensor]]\nname = \"two\"\nproduct = \"jn2101\"\nparameters.node-id = 11\n"
            ),
            4,
            "the factory address",
        ),
        (
            format!("{ONE}find = \"fastscan\"\n"),
            4,
            "jn2101 has no fastscan",
        ),
        (
            format!("{ONE}find = \"fastscan\"\n").replace("jn2101", "ims360"),
            2,
            "node-id",
        ),
        (
            format!("{ONE}find = \"fastscan\"\nparameters.can-protocol = \"j1939\"\nparameters.node-id = 60\n")
                .replace("jn2101", "ims360"),
            2,
            "none in J1939",
        ),
        (
            format!("{ONE}parameters.baud-rate = \"500 kbit/s\"\n"),
            1,
            "alone",
        ),
    ] {
        let (own, why) = fault(&text);
        assert!(own == line && why.contains(reason), "{text}: {own} {why}");
    }
    let alone = format!(
        "alone = true\n{ONE}parameters.baud-rate = \"500 kbit/s\"\n[[sensor]]\nname = \"two\"\nproduct = \"jn2101\"\n"
    );
    assert!(Plan::parse(&alone, None).is_ok());
}

#[test]
fn identifier_of_another_sensor_is_refused() {
    let sensor = |name: &str, ids: [&str; 3]| {
        let names = ["set-id", "reply-id", "sync-id"].iter().zip(ids);
        let ids = names.map(|(name, id)| format!("parameters.{name} = \"{id}\"\n"));
        let ids: String = ids.collect();
        format!("[[sensor]]\nname = \"{name}\"\nproduct = \"is2\"\n{ids}")
    };
    for (one, two, taken) in [
        (["310h", "311h", "100h"], ["320h", "321h", "100h"], None),
        (
            ["310h", "311h", "100h"],
            ["320h", "311h", "100h"],
            Some("311h is the reply-id of one"),
        ),
        (
            ["310h", "311h", "100h"],
            ["311h", "321h", "100h"],
            Some("311h is the reply-id of one"),
        ),
        (
            ["310h", "311h", "100h"],
            ["320h", "310h", "100h"],
            Some("310h is the set-id of one"),
        ),
        (
            ["310h", "311h", "100h"],
            ["320h", "100h", "101h"],
            Some("100h is the sync-id of one"),
        ),
        (
            ["310h", "311h", "100h"],
            ["320h", "321h", "310h"],
            Some("310h is the set-id of one"),
        ),
        // The second sensor has 300h, 301h and 100h until it is its turn.
        (
            ["310h", "301h", "100h"],
            ["320h", "321h", "100h"],
            Some("301h is the reply-id of one"),
        ),
        (
            ["301h", "310h", "100h"],
            ["320h", "321h", "100h"],
            Some("301h is the set-id of one"),
        ),
        (
            ["310h", "311h", "300h"],
            ["320h", "321h", "100h"],
            Some("300h is the sync-id of one"),
        ),
    ] {
        let (first, second) = (sensor("one", one), sensor("two", two));
        let told = Plan::parse(&format!("{first}{second}"), None).map(|_| ());
        let alone = format!("alone = true\n{first}{second}");
        match (told, taken) {
            (Ok(()), None) => {}
            (Err((place, why)), Some(taken)) => {
                assert_eq!(place, first.len(), "{two:?}: {why}");
                assert!(why.to_string().starts_with(taken), "{two:?}: {why}");
            }
            (told, _) => panic!("{one:?} {two:?}: {told:?}"),
        }
        assert!(Plan::parse(&alone, None).is_ok(), "{one:?} {two:?}");
    }
}

#[test]
fn sensors_that_share_a_bus_keep_its_bit_rate() {
    let sensor = |name: &str, product: &str, rate: &str| {
        let rate = match rate {
            "" => String::new(),
            rate => format!("parameters.baud-rate = \"{rate} kbit/s\"\n"),
        };
        format!("[[sensor]]\nname = \"{name}\"\nproduct = \"{product}\"\n{rate}")
    };
    let one = sensor("one", "is2", "500");
    let (fsc, canopen) = (sensor("two", "is2", "250"), sensor("two", "jn2101", ""));
    let delivered = sensor("one", "jn2101", "125");
    for (text, given, rate) in [
        (one.clone(), None, Ok(BitRate::K500)),
        (one.clone(), Some(BitRate::K500), Ok(BitRate::K500)),
        (one.clone(), Some(BitRate::K250), Err(0)),
        (format!("{one}{fsc}"), None, Err(one.len())),
        (format!("{one}{canopen}"), None, Err(0)),
        (delivered.clone(), None, Ok(BitRate::K125)),
        (delivered, Some(BitRate::K250), Err(0)),
    ] {
        let plan = Plan::parse(&text, given);
        let told = plan.as_ref().map(|plan| plan.rate().expect("a rate"));
        assert_eq!(told.map_err(|(place, _)| *place), rate, "{given:?} {text}");
    }
}
