//! A command as words, and as the line that a user can copy into a shell.

use crate::identify::Found;
use crate::scan::kbits;
use plumbline::can::BitRate;

/// The words of a command.
pub type Words = Vec<String>;

/// The line of a command: words that a shell would change are quoted.
pub fn shown(words: &[String]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| quoted(word)).collect();
    format!("plumbline {}", quoted.join(" "))
}

fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_./:=,%+-@".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// Adds an argument that is not an option, even if it looks like an option.
pub fn positional(words: &mut Words, values: &[String]) {
    if values.iter().any(|value| value.starts_with('-')) {
        words.push("--".to_owned());
    }
    words.extend_from_slice(values);
}

/// The options that select a bus.
pub fn bus(port: &str, rate: Option<BitRate>) -> Words {
    let mut words = vec!["--port".to_owned(), port.to_owned()];
    if let Some(rate) = rate {
        words.extend(["--rate".to_owned(), kbits(rate).to_string()]);
    }
    words
}

/// The options that select a sensor that was found: `eds` is the option of its data sheet.
pub fn selecting(
    port: &str,
    rate: Option<BitRate>,
    found: &Found,
    product: &str,
    eds: Option<String>,
) -> Words {
    let mut words = bus(port, rate);
    let option = found.target.protocol().option;
    words.extend([option.to_owned(), found.target.address()]);
    if let Some(eds) = eds {
        words.push(eds);
        return words;
    }
    // The product is an option only where the sensor does not say it.
    if found.product().is_none_or(|own| own.name != product) {
        words.extend(["--product".to_owned(), product.to_owned()]);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_line_are_quoted_for_a_shell() {
        let words = ["set", "name=a b", "it's", ""].map(str::to_owned);
        assert_eq!(shown(&words), r"plumbline set 'name=a b' 'it'\''s' ''");
    }

    #[test]
    fn value_that_looks_like_an_option_stays_a_value() {
        let mut words = vec!["set".to_owned()];
        positional(&mut words, &["--file=/etc/passwd".to_owned()]);
        assert_eq!(words, ["set", "--", "--file=/etc/passwd"]);
    }
}
