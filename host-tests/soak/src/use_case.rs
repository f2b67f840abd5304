//! What happens to a sensor, step by step, and what must hold after each.

use crate::settings::Settings;
use crate::stand::Stand;
use crate::step::{Counts, Step};
use crate::{Failure, motion, program, random::Random};
use plumbline::can::{Frame, extended, standard};
use plumbline::node::BusState;
use plumbline::time::{Duration, millis};
use plumbline_tool::error::Error;
use texts::Kind;

/// A sensor stores a value that it stores by itself within a second, which erasing pages can delay.
const STORES: Duration = millis(1_200);

/// After a fault of the bus, the sensor is back on it in this time, unless it is set to stay in bus-off.
const RECOVERS: Duration = millis(2000);

/// The angles are right after this time at rest: the slowest filter as delivered has settled.
const SETTLES: Duration = millis(10_000);

/// The largest error of an angle in degrees, with a resolution of 0.1 deg or finer.
const ACCURACY: f64 = 0.11;

/// A sensor in use.
pub struct UseCase {
    stand: Stand,
    random: Random,
    settings: Settings,
    /// How often each step happened so far.
    pub counts: Counts,
    /// Prints each step and each write.
    pub is_verbose: bool,
}

impl UseCase {
    /// A new sensor of this kind.
    ///
    /// # Errors
    /// It does not answer.
    pub fn new(kind: &str, seed: u64) -> Result<Self, Failure> {
        let mut random = Random::new(seed);
        let mut stand = Stand::new(kind, &mut random)?;
        let settings = Settings::of(stand.master())?;
        stand.master().release()?;
        Ok(Self {
            stand,
            random,
            settings,
            counts: Counts::default(),
            is_verbose: false,
        })
    }

    /// The simulated time so far.
    pub fn time(&self) -> Duration {
        Duration::from_ticks(self.stand.now().ticks())
    }

    /// The last frames on the bus.
    pub fn last_frames(&self) -> Vec<String> {
        self.stand.last_frames()
    }

    /// One step.
    ///
    /// # Errors
    /// The step, and what did not hold after it.
    pub fn step(&mut self) -> Result<(), (Step, Failure)> {
        let step = Step::any(&mut self.random);
        self.counts.add(step);
        if self.is_verbose {
            let time = self.stand.now().ticks();
            println!("{}.{:06} s {step:?}", time / 1_000_000, time % 1_000_000);
        }
        self.perform(step).map_err(|failure| (step, failure))
    }

    fn perform(&mut self, step: Step) -> Result<(), Failure> {
        match step {
            Step::Read => self.read(),
            Step::Write => self.write().map(|_| ()),
            Step::Save => self.save(),
            Step::Restart => self.restart(),
            Step::Load => self.load(),
            Step::PowerCycle => self.power_cycle(),
            Step::PowerCut => self.power_cut(),
            Step::Update => self.update(),
            Step::BadMemory => self.bad_memory(),
            Step::BusFault => self.bus_fault(),
            Step::Strangers => self.strangers(),
            Step::Move => {
                let moved = motion::any(&mut self.random, self.stand.axes);
                self.stand.set_motion(moved);
                Ok(())
            }
            Step::Measure => self.measure(),
            Step::ChangeMaster => Ok(self.stand.change_master()?),
            Step::Wait => {
                let time = self.random.below(5_000);
                Ok(self.stand.wait(millis(time))?)
            }
        }
    }

    fn read(&mut self) -> Result<(), Failure> {
        let at = self.random.below(self.settings.all.len() as u32) as usize;
        let entry = &self.settings.all[at].entry;
        let read = self.stand.master().read(entry)?;
        let before = self.settings.now[at];
        let name = || entry.name.clone();
        match read == before {
            true => Ok(()),
            false => Err(Failure::Changed {
                name: name(),
                read,
                before,
            }),
        }
    }

    /// Writes a setting. False: the sensor has refused it.
    fn write(&mut self) -> Result<bool, Failure> {
        let (at, number) = self
            .settings
            .any(&mut self.random, &self.stand.master().sheet);
        let setting = self.settings.all[at].clone();
        let written = self
            .stand
            .master()
            .write(&[(setting.entry.clone(), number)]);
        if self.is_verbose {
            let answer = written
                .as_ref()
                .map_or_else(Error::to_string, |()| "accepted".to_owned());
            println!("  {} = {number}: {answer}", setting.entry.name);
        }
        let is_accepted = is_accepted(written)?;
        if !is_accepted {
            self.compare()?;
            return Ok(false);
        }
        let read = self.stand.master().read(&setting.entry)?;
        if read != number {
            let name = setting.entry.name;
            return Err(Failure::Written {
                name,
                read,
                written: number,
            });
        }
        // A setting can change others: the mapping of a PDO, or what depends on the resolution.
        self.settings.now = self.settings.read(self.stand.master())?;
        if setting.is_stored_at_once {
            self.stand.wait(STORES)?;
            self.settings.store_at_once();
        }
        Ok(true)
    }

    fn save(&mut self) -> Result<(), Failure> {
        self.stand.master().save()?;
        self.settings.stored = vec![self.settings.now.clone()];
        Ok(())
    }

    fn restart(&mut self) -> Result<(), Failure> {
        self.stand.master().restart()?;
        self.stand.wait_for_start()?;
        self.started()
    }

    fn load(&mut self) -> Result<(), Failure> {
        self.stand.master().load_factory()?;
        self.stand.wait(STORES)?;
        self.stand.wait_for_start()?;
        // It says when they are in force, and whether they are stored: by a restart they are in force, and a save stores them.
        self.stand.master().restart()?;
        self.stand.wait(STORES)?;
        self.stand.return_to_protocol()?;
        self.settings.now = self.settings.read(self.stand.master())?;
        self.save()
    }

    fn power_cycle(&mut self) -> Result<(), Failure> {
        self.stand.wait(STORES)?;
        self.stand.power_cycle()?;
        self.started()
    }

    /// Cuts the supply in an operation of the memory, while it stores a setting or all of them.
    fn power_cut(&mut self) -> Result<(), Failure> {
        self.write()?;
        let (at, number) = self
            .settings
            .any(&mut self.random, &self.stand.master().sheet);
        let setting = self.settings.all[at].clone();
        if setting.changes_others {
            return Ok(());
        }
        let (others, seed) = (self.random.below(120), self.random.number());
        self.stand
            .flash(|flash| flash.cut_in_operation_after(others.into(), seed.into()));
        if self.is_verbose {
            println!(
                "  {} = {number}, cut after {others} operations",
                setting.entry.name
            );
        }
        // The sensor can be off before its answer.
        if setting.is_stored_at_once {
            let _ = self.stand.master().write(&[(setting.entry, number)]);
            self.stand.wait(STORES)?;
            let mut written = self.settings.stored.clone();
            written.iter_mut().for_each(|state| state[at] = number);
            self.settings.stored.extend(written);
        } else if self.stand.master().save().is_ok() {
            self.settings.stored = vec![self.settings.now.clone()];
        } else {
            self.settings.stored.push(self.settings.now.clone());
        }
        self.stand.power_cycle()?;
        self.started()
    }

    /// Replaces the program, in two of three cases with a power cut in an operation of its memory. Then the sensor has the old or the new
    /// program, or its bootloader takes the next one.
    fn update(&mut self) -> Result<(), Failure> {
        self.stand.wait(STORES)?;
        let product = self.stand.master().sheet.product;
        let image = program::any(&mut self.random, product);
        if self.random.below(3) > 0 {
            let operations = image.bytes.len() as u32 / 2 + 100;
            let (others, seed) = (self.random.below(operations), self.random.number());
            self.stand
                .program_flash(|flash| flash.cut_in_operation_after(others.into(), seed.into()));
            if self.is_verbose {
                println!("  cut after {others} of about {operations} operations");
            }
        }
        let loaded = self.stand.load(&image);
        let is_cut = self.stand.program_flash(|flash| {
            let is_cut = flash.is_cut();
            flash.power_on();
            is_cut
        });
        let mut right = vec![image];
        if is_cut {
            right.push(self.stand.program.clone());
            self.stand.bus.borrow_mut().power_cycle(self.stand.device);
            if self.stand.is_in_bootloader() {
                let next = program::any(&mut self.random, product);
                self.stand.load(&next)?;
                right = vec![next];
            }
        } else {
            loaded?;
        }
        self.stand.wait_for_start()?;
        let session = self.stand.master();
        let target = session.target;
        let read = target.program(session)?.map(|program| program.crc);
        let mut programs = right.iter();
        let program = programs.find(|image| read == Some(image.header.body()));
        match program.filter(|image| self.stand.has_program(image)) {
            Some(image) => self.stand.program = image.clone(),
            None => {
                let right = right.iter().map(|image| image.header.body()).collect();
                return Err(Failure::Program { read, right });
            }
        }
        self.started()
    }

    fn bad_memory(&mut self) -> Result<(), Failure> {
        let erases = self.random.below(2) == 0;
        self.stand.flash(|flash| match erases {
            true => flash.fail_erases(true),
            false => flash.fail_writes(true),
        });
        let saved = self.stand.master().save();
        if saved.is_ok() {
            self.settings.stored = vec![self.settings.now.clone()];
        }
        self.stand.flash(|flash| {
            flash.fail_erases(false);
            flash.fail_writes(false);
        });
        self.compare()
    }

    fn bus_fault(&mut self) -> Result<(), Failure> {
        let number = 1 + self.random.below(40);
        match self.random.below(4) {
            0 => self.stand.bus.borrow_mut().corrupt(number, None),
            1 => self.stand.bus.borrow_mut().drop_acknowledges(number),
            2 => {
                let now = self.stand.now();
                self.stand.bus.borrow_mut().noise(now);
            }
            _ => self
                .stand
                .bus
                .borrow_mut()
                .hold_dominant(millis(number * 5)),
        }
        // A request during the fault is lost, or not.
        let entry = self.settings.all[0].entry.clone();
        let _ = self.stand.master().read_once(&entry);
        self.stand.bus.borrow_mut().corrupt(0, None);
        self.stand.bus.borrow_mut().drop_acknowledges(0);
        self.stand.wait(RECOVERS)?;
        let is_off = {
            let bus = self.stand.bus.borrow();
            bus.device(self.stand.device).bus_state() == Some(BusState::BusOff)
        };
        if is_off {
            return self.power_cycle();
        }
        let session = self.stand.master();
        session.target.resume(&mut session.link)?;
        self.stand.wait_for_start()?;
        self.compare()
    }

    fn strangers(&mut self) -> Result<(), Failure> {
        for _ in 0..1 + self.random.below(20) {
            let id = match self.random.below(4) {
                0 => extended(self.random.number() & 0x1FFF_FFFF),
                1 => standard(0x80),
                // Neither NMT, LSS nor a request to the sensor.
                _ => standard(0x700 + self.random.below(0x40) as u16),
            };
            let data: Vec<u8> = (0..self.random.below(9))
                .map(|_| self.random.number() as u8)
                .collect();
            if let Some(frame) = Frame::data(id, &data) {
                self.stand.send_as_stranger(frame);
            }
        }
        self.read()
    }

    fn measure(&mut self) -> Result<(), Failure> {
        self.load()?;
        let (scene, angles) = motion::rest(&mut self.random, self.stand.axes);
        self.stand.set_motion(Box::new(scene));
        self.stand.wait(SETTLES)?;
        let session = self.stand.master();
        for (id, right) in session.sheet.product.guide.angles.iter().zip(angles) {
            let Some(entry) = session.sheet.value(*id).cloned() else {
                continue;
            };
            let scale = session.scale_of(&entry)?;
            let raw = session.read(&entry)?;
            let text = scale.value(entry.data_type.value(raw));
            let read: f64 = text.parse().unwrap_or(f64::NAN);
            // 359 deg is -1 deg.
            let turns = ((read - right) / 360.0).round();
            let is_right = (read - right - 360.0 * turns).abs() <= ACCURACY;
            if !is_right {
                let name = entry.name;
                return Err(Failure::Angle { name, read, right });
            }
        }
        Ok(())
    }

    /// All settings are as before.
    fn compare(&mut self) -> Result<(), Failure> {
        let read = self.settings.read(self.stand.master())?;
        let each = self.settings.all.iter().zip(read).zip(&self.settings.now);
        for ((setting, read), before) in each {
            if read != *before {
                let name = setting.entry.name.clone();
                return Err(Failure::Changed {
                    name,
                    read,
                    before: *before,
                });
            }
        }
        Ok(())
    }

    /// After a start the sensor has the settings of one of the states that the memory can have.
    fn started(&mut self) -> Result<(), Failure> {
        let read = self.settings.read(self.stand.master())?;
        if !self.settings.stored.contains(&read) {
            let names = self.settings.all.iter().zip(&read).enumerate();
            let stored = |at: usize| self.settings.stored.iter().map(move |state| state[at]);
            let mut wrong = names.filter(|(at, (_, read))| !stored(*at).any(|own| own == **read));
            let (at, (setting, number)) = wrong
                .next()
                .unwrap_or((0, (&self.settings.all[0], &read[0])));
            return Err(Failure::Stored {
                name: setting.entry.name.clone(),
                read: *number,
                stored: stored(at).collect(),
            });
        }
        self.settings.stored = vec![read.clone()];
        self.settings.now = read;
        Ok(())
    }
}

/// Whether the sensor has accepted a write.
///
/// # Errors
/// It does not answer.
fn is_accepted(written: Result<(), Error>) -> Result<bool, Error> {
    match written {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == Kind::Refused => Ok(false),
        Err(error) => Err(error),
    }
}
