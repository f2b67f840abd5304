//! Checks that the description of a product is consistent. The compiler evaluates them where the tables are written. A mistake is a compile
//! error that names the row.

use super::diagnostics::{CODES, Trouble};
use super::identifier::{
    ACTIVE_CODES, COMMANDED_ADDRESS, COMPONENT_IDENTIFICATION, ECU_IDENTIFICATION, LAST_ADDRESS,
    PROPRIETARY_A, Pgn, SOFTWARE_IDENTIFICATION,
};
use super::name::FIELDS;
use super::product::Product;
use super::signal::{Contents, Group, Signal, field};
use super::timers::Timers;
use super::transport::MESSAGE;
use crate::application::{Application, Values};
use crate::mistake::Mistake;
use crate::param::projection::{check_quantities, exists, highest};
use crate::param::{Parameter, ParameterId, Setting, Table};
use crate::store::unit::NAME;
use crate::walk::{at, each, equal};

/// The proof that the tables of a product were checked.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Checked(());

impl Checked {
    /// Checks the tables of a product.
    #[track_caller]
    pub const fn tables<P: Product>() -> Self {
        let parameters = <<P::Application as Application>::Table as Table>::PARAMETERS;
        check_quantities(
            <P::Application as Application>::QUANTITIES,
            <<P::Application as Application>::Values as Values>::CAPACITY,
        );
        check_groups(P::GROUPS);
        check_sent::<P>(parameters);
        check_name(&P::NAME, parameters);
        check_address(P::ADDRESS, parameters);
        check_texts::<P>();
        check_troubles(P::TROUBLES);
        Self(())
    }
}

/// The groups that the protocol itself sends or receives.
const PROTOCOL: [Pgn; 5] = [
    ACTIVE_CODES,
    COMMANDED_ADDRESS,
    COMPONENT_IDENTIFICATION,
    SOFTWARE_IDENTIFICATION,
    ECU_IDENTIFICATION,
];

/// The largest suspect parameter number: 19 bits.
const SPN_MAX: u32 = 0x7_FFFF;

/// The largest failure mode identifier: 5 bits.
const FMI_MAX: u8 = 31;

#[track_caller]
pub(super) const fn check_groups(groups: &[Group]) {
    each!(place, group in groups => {
        let mistake = group.mistake();
        mistake.unless(
            group.pgn <= 0x1_FFFF,
            "the number has more than 17 bits: the extended data page belongs to another protocol",
        );
        mistake.unless(
            group.pgn & 0xFF00 > PROPRIETARY_A,
            "a group with this number (PF below F0h) is not sent to all nodes",
        );
        mistake.unless(is_identifier(group.name), NAME_OF_DATABASE);
        each!(own in &PROTOCOL => {
            mistake.unless(*own != group.pgn, "the protocol itself has this group");
        });
        each!(other in groups.split_at(place).0 => {
            mistake.unless(other.pgn != group.pgn, "another group has this number");
            mistake.unless(!equal(other.name, group.name), "another group has this name");
        });
        check_signals(group);
    });
}

#[track_caller]
const fn check_signals(group: &Group) {
    let mut used = 0_u64;
    each!(place, signal in group.signals => {
        let mistake = signal.mistake(group);
        let before = group.signals.split_at(place).0;
        mistake.unless(is_identifier(signal.name), NAME_OF_DATABASE);
        mistake.unless(signal.bits >= 1, "the signal has no bits");
        field(mistake, signal);
        let bits = u64::MAX >> (64 - signal.bits as u32) << signal.start;
        mistake.unless(used & bits == 0, "another signal has some of its bits");
        used |= bits;
        mistake.unless(
            signal.spn <= SPN_MAX,
            "a suspect parameter number has 19 bits",
        );
        each!(other in before => {
            mistake.unless(
                signal.spn == 0 || other.spn != signal.spn,
                "another signal has this suspect parameter number",
            );
            mistake.unless(
                !equal(other.name, signal.name),
                "another signal has this name",
            );
        });
        if let Contents::Merit(source) = signal.contents {
            mistake.unless(
                has_value(before, source as u8),
                "a figure of merit comes after its value in the same group",
            );
        }
    });
}

const NAME_OF_DATABASE: &str =
    "a name in the database has up to 32 letters, digits and `_`, and begins with a letter";

/// Whether a name can be that of a message or of a signal in a database (DBC).
const fn is_identifier(name: &str) -> bool {
    each!(letter in name.as_bytes() => {
        if !(letter.is_ascii_alphanumeric() || *letter == b'_') {
            return false;
        }
    });
    name.len() <= 32 && matches!(name.as_bytes(), [first, ..] if first.is_ascii_alphabetic())
}

/// Whether one of these signals is the value of a source.
const fn has_value(signals: &[Signal], wanted: u8) -> bool {
    each!(signal in signals => {
        if let Contents::Value { source, .. } = signal.contents
            && source as u8 == wanted
        {
            return true;
        }
    });
    false
}

/// Checks that each group has its rows and its timer.
#[track_caller]
const fn check_sent<P: Product>(parameters: &[Parameter]) {
    let mut groups = P::GROUPS;
    each!(sent in P::SENT => {
        let [group, others @ ..] = groups else {
            Mistake::group(sent.pgn, "SENT")
                .text("GROUPS does not describe this group")
                .fail();
        };
        let mistake = group.mistake();
        mistake.unless(
            sent.pgn == group.pgn,
            "SENT has another group in this place: both tables have the same order",
        );
        check_setting(mistake, sent.rate, u32::MAX, parameters);
        check_setting(mistake, sent.priority, 7, parameters);
        groups = others;
    });
    if let [group, ..] = groups {
        group
            .mistake()
            .text("SENT has no row for this group")
            .fail();
    }
    Mistake::item("Timers").unless(
        P::SENT.len() == P::Timers::COUNT,
        "each group in SENT needs a timer, and each timer a group",
    );
}

/// Checks that a setting exists and is never above `most`.
#[track_caller]
const fn check_setting(mistake: Mistake, setting: Setting, most: u32, parameters: &[Parameter]) {
    let (number, mistake) = match setting {
        Setting::Constant(number) => (number, mistake),
        Setting::Parameter(id) => {
            exists(mistake, parameters, id);
            let parameter = at(parameters, id.0 as usize);
            let mistake = parameter.mistake();
            mistake.unless(
                !parameter.data_type.is_signed() && !parameter.data_type.is_wide(),
                "a parameter of the protocol is an unsigned number of up to 32 bits",
            );
            (highest(parameter), mistake)
        }
    };
    if number > most {
        mistake
            .text("the number ")
            .number(number)
            .text(" is too large, the protocol has room for ")
            .number(most)
            .fail();
    }
}

/// The fields of the NAME.
const NAMES: [&str; FIELDS.len()] = [
    "NAME, arbitrary address capable",
    "NAME, industry group",
    "NAME, vehicle system instance",
    "NAME, vehicle system",
    "NAME, function",
    "NAME, function instance",
    "NAME, ECU instance",
    "NAME, manufacturer code",
];

#[track_caller]
const fn check_name(name: &[Setting; FIELDS.len()], parameters: &[Parameter]) {
    each!(place, setting in name => {
        let (_, bits) = *at(&FIELDS, place);
        let mistake = Mistake::item(at::<&str>(&NAMES, place));
        check_setting(mistake, *setting, (1 << bits) - 1, parameters);
    });
}

#[track_caller]
const fn check_address(id: ParameterId, parameters: &[Parameter]) {
    let setting = Setting::Parameter(id);
    check_setting(
        Mistake::item("ADDRESS"),
        setting,
        LAST_ADDRESS as u32,
        parameters,
    );
}

#[track_caller]
const fn check_texts<P: Product>() {
    check_text("MAKE", P::MAKE, MESSAGE);
    check_text("MODEL", P::MODEL, NAME);
    check_text("VERSION", P::VERSION, NAME);
    check_text("TYPE", P::TYPE, MESSAGE);
    // The separators, and a serial number of 32 bits.
    Mistake::item("MAKE").unless(
        P::MAKE.len() + P::TYPE.len() + NAME + 5 + 10 <= MESSAGE,
        "the identification with MAKE and TYPE is longer than a message",
    );
}

#[track_caller]
const fn check_text(item: &str, text: &str, longest: usize) {
    let mistake = Mistake::item(item);
    mistake.unless(text.len() <= longest, "the text is too long");
    each!(letter in text.as_bytes() => {
        mistake.unless(
            letter.is_ascii_graphic() && *letter != b'*' || *letter == b' ',
            "the text has characters of ASCII without `*`, which ends it",
        );
    });
}

#[track_caller]
const fn check_troubles(troubles: &[Trouble]) {
    Mistake::item("TROUBLES").unless(
        troubles.len() <= CODES,
        "there are more than 14 trouble codes",
    );
    each!(place, Trouble { code, origin } in troubles => {
        let mistake = Mistake::row("trouble code", place).at(*origin);
        mistake.unless(code.spn <= SPN_MAX, "a suspect parameter number has 19 bits");
        mistake.unless(code.fmi <= FMI_MAX, "a failure mode identifier has 5 bits");
        each!(Trouble { code: other, .. } in troubles.split_at(place).0 => {
            mistake.unless(
                other.spn != code.spn || other.fmi != code.fmi,
                "another row has this trouble code",
            );
        });
    });
}

#[cfg(test)]
mod tests {
    use super::super::signal::Source;
    use super::*;

    const VALUE: Signal = Signal::new(
        "Slope",
        3318,
        0,
        16,
        Contents::Value {
            source: Source::Pitch,
            resolution: (1, 1000),
            offset: -64,
            unit: "deg",
        },
    );
    const MERIT: Signal = Signal::new("Merit", 3323, 16, 2, Contents::Merit(Source::Pitch));

    /// Checks a group with these signals.
    fn check(signals: &'static [Signal]) {
        let name = "SLOPE";
        check_groups(&[Group::new(name, 0xFF20, signals)]);
    }

    #[test]
    fn value_and_its_merit_are_accepted() {
        check(&[VALUE, MERIT]);
    }

    #[test]
    #[should_panic = "group 65312 \"SLOPE\", signal \"Merit\": a figure of merit comes after its value"]
    fn merit_before_its_value_is_refused() {
        check(&[MERIT, VALUE]);
    }
}
