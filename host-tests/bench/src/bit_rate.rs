//! The bit rate as an option of a program.

use plumbline::can::BitRate;

/// One of the ten bit rates, in kbit/s.
///
/// # Errors
/// The text is not one of them; the message names all of them.
pub fn bit_rate(text: &str) -> Result<BitRate, String> {
    let kbits = |rate: &BitRate| f64::from(rate.bits_per_second()) / 1000.0;
    let wanted = text.parse::<f64>().ok();
    BitRate::ALL
        .into_iter()
        .find(|rate| Some(kbits(rate)) == wanted)
        .ok_or_else(|| {
            let all: Vec<String> = BitRate::ALL
                .iter()
                .map(|rate| kbits(rate).to_string())
                .collect();
            format!("the bit rates are {} kbit/s", all.join(", "))
        })
}
