//! `parameters`: the names of a product.

use crate::error::Error;
use crate::output::Terminal;
use crate::sheet::{Origin, Sheet};
use serde_json::{Map, Value, json};

/// Lists the names of a product with range, unit and factory value.
pub(super) fn list(sheet: &Sheet, terminal: &mut Terminal) -> Result<(), Error> {
    let mut document = Map::new();
    terminal.line(format!("{} ({})", sheet.product.name, sheet.product.maker))?;
    let width = sheet
        .entries
        .iter()
        .map(|entry| entry.name.len())
        .max()
        .unwrap_or(0);
    for entry in &sheet.entries {
        let access = match (entry.readable, entry.writable) {
            (true, true) => "rw",
            (false, _) => "wo",
            _ => "ro",
        };
        let factory = entry.factory.map(|factory| match entry.node_relative {
            true => format!("{} + node-ID", entry.text(factory)),
            false => entry.text(factory),
        });
        let range = if entry.writable {
            entry.range().to_string()
        } else {
            String::new()
        };
        let range = match &range[..] {
            "" => entry.scale.unit.to_owned(),
            _ => range,
        };
        let range = match sheet.follows_resolution(entry) {
            true => format!("{range}, in steps of the resolution"),
            false => range,
        };
        let end = factory
            .as_ref()
            .map_or(String::new(), |factory| format!(" [factory: {factory}]"));
        terminal.line(format!("  {:width$}  {access}  {range}{end}", entry.name))?;
        let groups = sheet.product.guide.groups.iter();
        let mut groups =
            groups.filter(|(_, ids)| ids.iter().any(|id| entry.origin == Origin::Parameter(*id)));
        document.insert(
            entry.name.clone(),
            json!({
                "title": entry.title,
                "access": access,
                "range": range,
                "unit": entry.scale.unit,
                "factory": entry.factory.map(|factory| entry.json(factory)),
                "stored": entry.stored,
                "group": groups.next().map(|(name, _)| *name),
            }),
        );
    }
    for (name, ids) in sheet.product.guide.groups {
        let names = ids.iter().filter_map(|id| sheet.parameter(*id));
        let names: Vec<&str> = names.map(|entry| entry.name.as_str()).collect();
        terminal.line(format!("  {name:width$}  together: {}", names.join(", ")))?;
    }
    terminal.document(&Value::Object(document))
}
