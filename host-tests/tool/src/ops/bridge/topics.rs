//! The topics and documents of a bridge: `SITE/BUS/SENSOR/...`.

use super::known::Known;
use super::sensor::About;
use crate::error::{BrokerError, Error};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use texts::SHOWN;

/// What a broker tells about something that is there, and about something that is not.
pub const HERE: [&str; 2] = ["offline", "online"];

/// The longest name in bytes: a topic with its sample must fit into a record of the buffer.
const LONGEST: usize = 100;

/// The topics of a bus.
#[derive(Clone, Debug)]
pub struct Topics {
    site: String,
    bus: String,
    /// The first part of the topics for the discovery; None: none.
    discovery: Option<String>,
}

impl Topics {
    /// The topics with these parts. An empty `discovery` is none.
    ///
    /// # Errors
    /// A name cannot be a part of a topic.
    pub fn new(site: &str, bus: &str, discovery: &str) -> Result<Self, Error> {
        let is_valid = |name: &str| {
            let is_wrong = |letter: char| "/+#".contains(letter) || letter.is_control();
            // A broker keeps topics with $ for itself.
            (1..=LONGEST).contains(&name.len())
                && !name.starts_with('$')
                && !name.contains(is_wrong)
        };
        let checked = |option, name: &str| match is_valid(name) {
            true => Ok(name.to_owned()),
            false => {
                let name = name.chars().take(SHOWN).collect();
                Err(Error::from(BrokerError::Topic(option, name)))
            }
        };
        let discovery = match discovery {
            "" => None,
            name => Some(checked("--discovery", name)?),
        };
        Ok(Self {
            site: checked("--site", site)?,
            bus: checked("--bus", bus)?,
            discovery,
        })
    }

    /// The name of this client, which a broker knows once. The bus has no `-` in it, so no other site and bus have the same name.
    pub fn client(&self) -> String {
        let bus = self.bus.replace('%', "%25").replace('-', "%2D");
        format!("plumbline-{}-{bus}", self.site)
    }

    /// Whether the bridge is there.
    pub fn bridge(&self) -> String {
        format!("{}/{}/bridge/availability", self.site, self.bus)
    }

    /// A topic of a sensor.
    pub fn sensor(&self, about: &About, topic: &str) -> String {
        format!("{}/{}/{}/{topic}", self.site, self.bus, about.name)
    }

    /// The name of the sensor with this topic; None: it is on another bus.
    fn name<'a>(&self, topic: &'a str) -> Option<&'a str> {
        let parts: Vec<&str> = topic.split('/').collect();
        match parts[..] {
            [site, bus, name, _] if site == self.site && bus == self.bus => Some(name),
            _ => None,
        }
    }

    /// The makers of the sensors of this bus in earlier runs, by their names.
    pub fn makers(&self, known: &Known) -> BTreeMap<String, String> {
        let known = known.makers().iter();
        let known = known.filter_map(|(topic, maker)| Some((self.name(topic)?, maker)));
        known
            .map(|(name, maker)| (name.to_owned(), maker.clone()))
            .collect()
    }

    /// What Home Assistant must know of a sensor: the topics and their documents.
    pub fn discovery(&self, about: &About) -> Vec<(String, Value)> {
        let Some(discovery) = &self.discovery else {
            return Vec::new();
        };
        let unit = identifier(&format!("{}-{}", self.client(), about.name));
        let identity = &about.identity;
        let product = identity["product"].as_str().unwrap_or("sensor");
        let label = identity["label"].as_str();
        let name = label.map_or_else(|| format!("{product} {}", about.name), str::to_owned);
        let mut device = json!({
            "identifiers": [unit],
            "name": name,
            "manufacturer": about.maker,
            "model": product,
            "serial_number": identity["serial"].as_u64().map(|serial| serial.to_string()),
            "sw_version": identity["firmware"],
        });
        if let Some(device) = device.as_object_mut() {
            // Home Assistant refuses a document with a text that is null.
            device.retain(|_, value| !value.is_null());
        }
        let common = json!({
            "availability": [{"topic": self.bridge()}, {"topic": self.sensor(about, "availability")}],
            "availability_mode": "all",
            "device": device,
            "origin": {"name": "plumbline", "sw_version": env!("CARGO_PKG_VERSION")},
        });
        let entity = |kind: &str, name: &str, own: Value| {
            let mut document = common.clone();
            let id = identifier(name);
            document["unique_id"] = json!(format!("{unit}-{id}"));
            document["name"] = json!(name.replace('_', " "));
            if let (Some(document), Value::Object(own)) = (document.as_object_mut(), own) {
                document.extend(own);
            }
            (format!("{discovery}/{kind}/{unit}/{id}/config"), document)
        };
        let angle = |column: &String| {
            let (name, unit) = column.rsplit_once('_').unwrap_or((column, ""));
            let own = json!({
                "state_topic": self.sensor(about, "angle"),
                "value_template": format!("{{{{ value_json.{column} }}}}"),
                "unit_of_measurement": if unit == "deg" { "°" } else { unit },
                "state_class": "measurement",
            });
            entity("sensor", name, own)
        };
        let mut entities: Vec<_> = about.angles.iter().map(angle).collect();
        let problem = json!({
            "state_topic": self.sensor(about, "status"),
            "value_template": "{{ 'ON' if value_json.errors else 'OFF' }}",
            "device_class": "problem",
            "entity_category": "diagnostic",
        });
        entities.push(entity("binary_sensor", "status", problem));
        entities
    }
}

/// A name with the characters that Home Assistant permits in a topic.
fn identifier(name: &str) -> String {
    let permitted = |letter: char| match letter.is_ascii_alphanumeric() || "_-".contains(letter) {
        true => letter,
        false => '_',
    };
    name.chars().map(permitted).collect()
}

/// The name of a bus by its port: can0, ttyACM0, 127.0.0.1-11898.
pub fn bus_of(port: &str) -> String {
    let name = port.trim_end_matches('/').rsplit('/').next();
    let name = name.and_then(|name| name.strip_prefix("slcan:").or(Some(name)));
    name.unwrap_or_default().replace(['+', '#', ':'], "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn client_has_another_name_for_each_site_and_bus() {
        let client = |site, bus| Topics::new(site, bus, "").unwrap().client();
        assert_eq!(client("crane-17", "can0"), "plumbline-crane-17-can0");
        assert_eq!(client("a", "b-c"), "plumbline-a-b%2Dc");
        assert_ne!(client("a-b", "c"), client("a", "b-c"));
        assert_ne!(client("a", "b%2Dc"), client("a", "b-c"));
    }

    #[test]
    fn discovery_has_no_null_for_what_the_sensor_does_not_tell() {
        let topics = Topics::new("site", "bus", "homeassistant").unwrap();
        let about = About {
            name: "canopen-10".to_owned(),
            line: String::new(),
            maker: "ifm",
            identity: json!({"product": "jn2101", "serial": null, "firmware": null}),
            angles: vec!["angle_x_deg".to_owned()],
        };
        let device = json!({
            "identifiers": ["plumbline-site-bus-canopen-10"],
            "name": "jn2101 canopen-10",
            "manufacturer": "ifm",
            "model": "jn2101",
        });
        for (topic, document) in topics.discovery(&about) {
            assert_eq!(document["device"], device, "{topic}");
        }
    }
}
