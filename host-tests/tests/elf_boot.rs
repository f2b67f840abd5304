//! scratch
use host_tests::bench::{Bus, BusRate, Flash, Sensor};
use host_tests::stm32f103::Microcontroller;
use host_tests::stm32f103::elf::Image;
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::Instant;
use std::rc::Rc;

#[test]
fn boots() {
    let path = std::env::var("ELF").unwrap();
    let image = Rc::new(Image::parse(&std::fs::read(path).unwrap()).unwrap());
    let level = Reading { acceleration: I32x3 { x: 0, y: 0, z: ONE_G }, temperature: 2500, ..Reading::default() };
    let mcu = Microcontroller::new("is2", image, 1, Flash::default(), Box::new(level));
    let mut bus = Bus::new(BusRate::Follow);
    let id = bus.attach(mcu);
    let a = bus.adapter();
    bus.open(a, None, false);
    let t = std::time::Instant::now();
    bus.run_until(Instant::from_ticks(1_000_000));
    println!("1 s in {:?}", t.elapsed());
    let f = |d: &[u8]| plumbline::can::Frame::data(plumbline::can::standard(0x300), d).unwrap();
    bus.send(a, f(&[0]));
    bus.run_until(Instant::from_ticks(1_200_000));
    bus.send(a, f(&[0]));
    bus.send(a, f(&[0x10]));
    bus.run_until(Instant::from_ticks(1_300_000));
    for (t, f) in bus.take_received(a) { println!("{t} {f:?}"); }
    println!("{:?} {:?} {:?}", bus.device(id).rate(), bus.device(id).mode(), bus.device(id).leds());
    let t = std::time::Instant::now();
    bus.run_until(Instant::from_ticks(11_300_000));
    println!("10 s in {:?}", t.elapsed());
}
