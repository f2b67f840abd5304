//! DeviceNet: the attributes of the objects, and stored parameters.

use crate::tester::Tester;
use crate::tester::devicenet::{Level, LevelTester, allocated, compare};
use plumbline::devicenet::DevicenetNode;
use plumbline::node::{Action, Boot};

#[test]
fn identity_has_its_attributes() {
    compare(
        0,
        &[
            ("0E010101", "8E6201"),
            ("0E010102", "8E0000"),
            ("0E010103", "8E0700"),
            ("0E010104", "8E0102"),
            // Owned. The MAC ID is 3, but that is no configuration of the application (T32).
            ("0E010105", "8E0100"),
            ("0E010106", "8E01020304"),
        ],
    );
}

#[test]
fn devicenet_object_has_its_attributes() {
    compare(
        0x52,
        &[
            ("0E030101", "8E03"),
            ("0E030102", "8E00"),
            ("0E030103", "8E00"),
            ("1003010301", "90"),
            ("0E030103", "8E01"),
            ("0E030104", "8E00"),
            ("0E030105", "8E530A"),
        ],
    );
}

#[test]
fn assemblies_contain_their_words() {
    compare(
        0,
        &[
            ("0E046503", "8ED204"),
            ("0E046603", "8EC9FD"),
            ("0E046703", "8ED204C9FD"),
            ("0E046803", "9416FF"),
        ],
    );
}

#[test]
fn vendor_object_reads_parameters_values_and_constants() {
    compare(
        0,
        &[
            ("0E650101", "8E0B00"),
            ("0E650171", "8E0A00"),
            ("0E650172", "8ED204"),
            ("0E650173", "8EFDFF"),
            ("0E650175", "8E00"),
            ("0E650176", "8E0000"),
            ("0E650178", "8E50D41200"),
            ("0E65017A", "8EC9FD"),
            ("0E650181", "8E67"),
            ("106501739CFF", "90"),
            ("0E650173", "8E9CFF"),
            ("106501736400", "90"),
            ("0E650173", "8E6400"),
        ],
    );
}

#[test]
fn connections_have_their_attributes() {
    // Explicit, poll, COS with acknowledge.
    let mut tester = allocated(0x12);
    for (attribute, explicit, poll, cos) in [
        ("01", "03", "01", "01"),
        ("02", "00", "01", "01"),
        ("03", "83", "82", "13"),
        ("04", "1B04", "C303", "4303"),
        ("05", "1C04", "1D04", "1A04"),
        ("06", "21", "01", "01"),
        ("07", "2200", "0400", "0400"),
        ("08", "2000", "0000", "0000"),
        ("09", "C409", "0000", "0000"),
        ("0C", "01", "00", "00"),
        ("0D", "0000", "0600", "0600"),
        ("0E", "", "200424673003", "200424673003"),
        ("0F", "0000", "0000", "0400"),
        ("10", "", "", "202B2401"),
    ] {
        for (instance, expected) in [("01", explicit), ("02", poll), ("04", cos)] {
            let response = tester.explicit(&format!("0E05{instance}{attribute}"));
            assert_eq!(response, format!("8E{expected}"), "{instance} {attribute}");
        }
    }
    assert_eq!(tester.explicit("0E050111"), "9414FF");
    assert_eq!(tester.explicit("0E050211"), "9414FF");
    assert_eq!(tester.explicit("0E050411"), "8E0000");
    assert_eq!(tester.explicit("0E050301"), "9416FF");
    tester.set_rate(2, 0);
    assert_eq!(tester.explicit("0E050201"), "8E03");
}

#[test]
fn attributes_of_connection_4_follow_its_choice() {
    for (choice, trigger, consumed, communication, length, path) in [
        (0x10, "13", "1A04", "01", "0400", "202B2401"),
        (0x20, "03", "1A04", "01", "0400", "202B2401"),
        (0x50, "10", "FFFF", "0F", "0000", ""),
        (0x60, "00", "FFFF", "0F", "0000", ""),
    ] {
        let mut tester = allocated(choice);
        for (attribute, expected) in [
            ("01", "01"),
            ("02", "01"),
            ("03", trigger),
            ("04", "4303"),
            ("05", consumed),
            ("06", communication),
            ("07", "0400"),
            ("08", "0000"),
            ("09", "0000"),
            ("0C", "00"),
            ("0D", "0600"),
            ("0E", "200424673003"),
            ("0F", length),
            ("10", path),
            ("11", "0000"),
        ] {
            let response = tester.explicit(&format!("0E0504{attribute}"));
            assert_eq!(
                response,
                format!("8E{expected}"),
                "{choice:02X} {attribute}"
            );
        }
        assert_eq!(tester.explicit("0E050201"), "9416FF");
    }
}

#[test]
fn connection_that_is_not_allocated_does_not_exist() {
    compare(
        0,
        &[
            ("0E050101", "8E03"),
            ("0E050201", "9416FF"),
            ("100502090000", "9416FF"),
            ("0E050401", "9416FF"),
        ],
    );
}

#[test]
fn produced_size_path_and_data_follow_the_selected_assembly() {
    const ASSEMBLIES: [(&str, &str, &str); 3] = [
        ("65", "0200", "D204"),
        ("66", "0200", "C9FD"),
        ("67", "0400", "D204C9FD"),
    ];
    for (polled, poll_size, poll_data) in ASSEMBLIES {
        for (cyclic, cos_size, cos_data) in ASSEMBLIES {
            let mut tester = allocated(0);
            assert_eq!(tester.explicit(&format!("10650181{polled}")), "90");
            assert_eq!(tester.explicit(&format!("10650182{cyclic}")), "90");
            tester.allocate(0x52);
            for (request, response) in [
                ("0E050207", poll_size.to_owned()),
                ("0E05020E", format!("200424{polled}3003")),
                ("0E050407", cos_size.to_owned()),
                ("0E05040E", format!("200424{cyclic}3003")),
            ] {
                assert_eq!(tester.explicit(request), format!("8E{response}"));
            }
            tester.set_rate(2, 0);
            assert_eq!(tester.exchange("41D#"), [format!("3C3#{poll_data}")]);
            let sent = tester.exchange("41C#0A100504090000");
            assert_eq!(sent, ["41B#0A900000".to_owned(), format!("343#{cos_data}")]);
        }
    }
}

#[test]
fn sets_are_stored_together_within_a_second() {
    let mut tester = allocated(0);
    tester.actions.clear();
    tester.explicit("106501712C01");
    tester.wait(200);
    tester.explicit("106501731000");
    tester.wait(99);
    assert_eq!(tester.actions, []);
    tester.wait(900);
    assert_eq!(tester.actions.len(), 1, "one save");
    assert_eq!(tester.memory.as_ref().unwrap()[6..10], [0x2C, 1, 0x10, 0]);
    // The same value again, and a parameter that is not stored.
    tester.explicit("106501712C01");
    tester.explicit("1065017505");
    tester.wait(1000);
    assert_eq!(tester.actions.len(), 1);
    assert_eq!(tester.explicit("0E650175"), "8E05");
}

#[test]
fn change_is_stored_within_a_second_while_others_follow() {
    let mut tester = allocated(0);
    for number in 1..=10 {
        tester.explicit(&format!("10650171{number:02X}00"));
        tester.wait(99);
    }
    let stored = tester.memory.as_ref().unwrap()[6];
    assert!(stored >= 4, "{stored}");
    tester.wait(300);
    assert_eq!(tester.memory.as_ref().unwrap()[6], 10);
}

#[test]
fn change_during_a_save_is_stored_after_it() {
    let mut tester = allocated(0);
    tester.memory_works = None;
    tester.explicit("106501712C01");
    tester.wait(400);
    tester.explicit("106501731000");
    assert_eq!(tester.explicit("0E650173"), "8E1000");
    tester.wait(500);
    tester.memory_works = Some(true);
    tester.finish_save(Ok(()));
    assert_eq!(tester.memory.as_ref().unwrap()[6..10], [0x2C, 1, 0x10, 0]);
}

#[test]
fn failed_save_is_repeated_and_reported() {
    let mut tester = allocated(0);
    tester.memory_works = Some(false);
    tester.explicit("106501712C01");
    tester.wait(350);
    assert_eq!(tester.explicit("0E010105"), "8E0501");
    tester.memory_works = Some(true);
    tester.wait(350);
    assert_eq!(tester.explicit("0E010105"), "8E0500");
    assert_eq!(tester.memory.as_ref().unwrap()[6..8], [0x2C, 1]);
}

/// The nodes with a memory that is damaged and with one that is not usable: with factory values, on-line and allocated.
fn with_unusable_memory() -> [LevelTester; 2] {
    let damaged = Boot {
        damaged: true,
        ..Boot::default()
    };
    // The MAC ID 64.
    let not_usable = Boot {
        parameters: Some(&[64]),
        ..Boot::default()
    };
    [damaged, not_usable].map(|boot| {
        let mut tester = Tester::power_up(boot, DevicenetNode::<Level>::new);
        assert_eq!(tester.wait_text(2001).len(), 2);
        assert_eq!(tester.exchange("5FE#0A4B0301010A"), ["5FB#0ACB00"]);
        assert_eq!(tester.exchange("5FC#0A0E010105"), ["5FB#0A8E0101"]);
        assert!(!tester.actions.contains(&Action::Save), "no change");
        tester
    })
}

#[test]
fn set_to_the_factory_value_mends_an_unusable_memory() {
    for mut tester in with_unusable_memory() {
        assert_eq!(tester.exchange("5FC#0A106501710A00"), ["5FB#0A90"]);
        tester.wait(1000);
        assert_eq!(tester.memory.as_ref().unwrap()[..2], [63, 0]);
        assert_eq!(tester.exchange("5FC#0A0E010105"), ["5FB#0A8E0100"]);
        tester.actions.clear();
        assert_eq!(tester.exchange("5FC#0A106501710A00"), ["5FB#0A90"]);
        tester.wait(1000);
        assert!(!tester.actions.contains(&Action::Save), "no change");
    }
}

#[test]
fn reset_type_1_mends_an_unusable_memory() {
    for mut tester in with_unusable_memory() {
        tester.actions.clear();
        assert_eq!(tester.exchange("5FC#0A05010101"), ["5FB#0A85"]);
        tester.wait(500);
        let order = tester.actions.iter();
        let order: Vec<_> = order
            .filter(|action| matches!(action, Action::Save | Action::Restart))
            .collect();
        assert_eq!(order, [&Action::Save, &Action::Restart]);
        tester.power_cycle();
        assert_eq!(tester.wait_text(2001).len(), 2);
        assert_eq!(tester.exchange("5FE#0A4B0301010A"), ["5FB#0ACB00"]);
        assert_eq!(tester.exchange("5FC#0A0E010105"), ["5FB#0A8E0100"]);
    }
}

#[test]
fn own_attribute_is_read_written_and_stored_by_its_functions() {
    let mut tester = allocated(0);
    for (request, response) in [
        ("0E660101", "8E01"),
        // X is 1234.
        ("0E660102", "8ED304"),
        // 250, and more than the parameter can have.
        ("1066010119", "90"),
        ("0E660101", "8E19"),
        ("0E650171", "8EFA00"),
        ("1066010165", "9409FF"),
        ("0E660101", "8E19"),
        ("106601020000", "940EFF"),
    ] {
        assert_eq!(tester.explicit(request), response, "{request}");
    }
    tester.wait(400);
    let stored = tester.memory.as_deref();
    assert_eq!(
        stored,
        Some(&[3, 0, 0, 103, 103, 0, 250, 0, 0xFD, 0xFF, 0, 0][..])
    );
}
