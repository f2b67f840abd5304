//! The rows of the tables of a product as entries with names.

use super::{Address, Entry, Form, Origin, kebab};
use crate::master::Protocol;
use crate::number::Scale;
use plumbline::model::catalog::Product;
use plumbline::param::{
    DataType, Parameter, ParameterId, Permitted, Persistence, Quantity, ValueId,
};
use std::collections::HashMap;

/// All entries of a product, in the order of its tables.
pub(super) fn entries(product: &'static Product) -> Vec<Entry> {
    let mut builder = Builder {
        product,
        entries: Vec::new(),
    };
    (Protocol::of(product).rows)(&mut builder);
    named(builder.entries, |entry| {
        let Origin::Parameter(id) = entry.origin else {
            return None;
        };
        let mut names = product.guide.short_names.iter();
        names.find(|(own, _)| *own == id).map(|(_, name)| *name)
    })
}

/// An entry before it has its name: its group is the name of the object that it is a part of.
pub(crate) struct Row {
    pub group: String,
    pub entry: Entry,
}

/// The rows so far.
pub(crate) struct Builder {
    pub product: &'static Product,
    entries: Vec<Row>,
}

impl Builder {
    pub fn push(&mut self, group: impl Into<String>, entry: Entry) {
        let group = group.into();
        self.entries.push(Row { group, entry });
    }

    pub fn of_parameter(&self, id: ParameterId, address: Address) -> Entry {
        let parameter: &Parameter = &self.product.parameters[usize::from(id.0)];
        Entry {
            title: parameter.name.to_owned(),
            origin: Origin::Parameter(id),
            data_type: parameter.data_type,
            scale: Scale::of(parameter.unit, parameter.decimals),
            permitted: parameter.permitted,
            meanings: parameter.meanings,
            factory: Some(parameter.factory),
            writable: true,
            stored: parameter.persistence != Persistence::Volatile,
            ..fact("", address, parameter.data_type)
        }
    }

    pub fn of_value(&self, id: ValueId, address: Address) -> Entry {
        let quantity: &Quantity = &self.product.quantities[usize::from(id.0)];
        Entry {
            title: quantity.name.to_owned(),
            origin: Origin::Value(id),
            scale: Scale::of(quantity.unit, quantity.decimals),
            ..fact("", address, quantity.data_type)
        }
    }

    pub fn is_at_once(&self, entry: &Entry) -> bool {
        let Origin::Parameter(id) = entry.origin else {
            return false;
        };
        self.product.parameters[usize::from(id.0)].persistence == Persistence::AtOnce
    }
}

/// A fact that can only be read.
pub(crate) fn fact(title: &str, address: Address, data_type: DataType) -> Entry {
    Entry {
        name: String::new(),
        title: title.to_owned(),
        origin: Origin::Fact,
        address,
        data_type,
        scale: Scale::PLAIN,
        form: Form::Decimal,
        permitted: Permitted::Any,
        meanings: &[],
        factory: None,
        node_relative: false,
        readable: true,
        writable: false,
        stored: false,
        command: false,
    }
}

/// The name of a group of sub-indices. PDOs have many rows with the same names, so their group is short.
pub(crate) fn group_of(index: u16, name: &str) -> String {
    match index {
        0x1400..=0x15FF => format!("rpdo{}", index - 0x13FF),
        0x1600..=0x17FF => format!("rpdo{}", index - 0x15FF),
        0x1800..=0x19FF => format!("tpdo{}", index - 0x17FF),
        0x1A00..=0x1BFF => format!("tpdo{}", index - 0x19FF),
        _ => name.to_owned(),
    }
}

/// Gives every row its name: the short name, or the name from its title. If several rows have the same name, the group or the address is
/// added.
pub(crate) fn named(rows: Vec<Row>, short: impl Fn(&Entry) -> Option<&'static str>) -> Vec<Entry> {
    let own = |entry: &Entry| match short(entry) {
        Some(name) => name.to_owned(),
        None => kebab(&entry.title),
    };
    let plain: Vec<(String, String)> = rows
        .iter()
        .map(|row| (own(&row.entry), row.group.clone()))
        .collect();
    let (mut names, mut in_group) = (HashMap::new(), HashMap::new());
    for both in &plain {
        *names.entry(&both.0).or_insert(0) += 1;
        *in_group.entry(both).or_insert(0) += 1;
    }
    let name = |both: &(String, String), address: Address| {
        let (own, group) = both;
        if names.get(own) == Some(&1) {
            return own.clone();
        }
        match address {
            _ if in_group.get(both) == Some(&1) && !group.is_empty() => {
                format!("{}-{own}", kebab(group))
            }
            Address::Object { index, sub } => format!("{own}-{index:04x}-{sub}"),
            _ => own.clone(),
        }
    };
    let named: Vec<String> = plain
        .iter()
        .zip(&rows)
        .map(|(both, row)| name(both, row.entry.address))
        .collect();
    let entries = rows.into_iter().zip(named);
    entries
        .map(|(row, name)| Entry { name, ..row.entry })
        .collect()
}
