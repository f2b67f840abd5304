//! Tests of two slots.

use super::super::failure::Failure;
use super::super::header::{Header, SIZE};
use super::super::loader::Loader;
use super::super::simulated::{DEVICE, Flash, file};
use super::*;
use std::vec::Vec;

const OLD: u32 = 0x0001_0000;
const NEW: u32 = 0x0001_0001;

/// A board with two slots.
#[derive(Clone)]
struct Board {
    run: Flash,
    download: Flash,
}

impl Board {
    /// A board with this program.
    fn with(file: &[u8]) -> Self {
        let mut board = Self {
            run: Flash::blank(),
            download: Flash::blank(),
        };
        board.download(file).unwrap();
        board.start().unwrap();
        board.run.operations = 0;
        board.download.operations = 0;
        board
    }

    /// Downloads a file, and returns the program that the client sees afterwards.
    fn download(&mut self, file: &[u8]) -> Result<Program, Failure> {
        let mut program = Program::of(&self.run);
        self.download.other = program;
        let mut loader = Loader::new();
        loader.clear();
        for piece in file.chunks(217) {
            loader.take(&mut self.download, &DEVICE, &mut program, piece)?;
            assert_eq!(
                program, self.download.other,
                "it can be started until the end"
            );
        }
        loader.finish(&mut self.download, &mut program)?;
        Ok(program)
    }

    fn start(&mut self) -> Result<(), SlotError> {
        install(&mut self.run, &mut self.download, || {})
    }

    /// Starts with power, and returns the version of the program.
    fn version_after_power_up(&mut self) -> Option<u32> {
        (self.run.power, self.download.power) = (None, None);
        self.start().unwrap();
        Program::of(&self.run).header().map(Header::version)
    }
}

/// The files of two programs with other contents.
fn files() -> [Vec<u8>; 2] {
    [file(OLD, 2048, 1), file(NEW, 3072, 2)]
}

#[test]
fn next_start_copies_download_once() {
    let [old, new] = files();
    let mut board = Board::with(&old);
    let before = board.run.bytes.clone();
    let program = board.download(&new).unwrap();
    assert_eq!(program.header().map(Header::version), Some(NEW));
    assert_eq!(board.run.bytes, before, "the old program is there");
    let mut pauses = 0;
    install(&mut board.run, &mut board.download, || pauses += 1).unwrap();
    assert_eq!(pauses, 3 + 2, "three pages erased, two programmed");
    assert_eq!(board.run.bytes[SIZE..512], new[2 * SIZE..SIZE + 512]);
    assert_eq!(board.run.bytes[576..3072], new[SIZE + 576..]);
    // A probe has flashed another program.
    board.run = Board::with(&old).run;
    assert_eq!(board.version_after_power_up(), Some(OLD));
}

#[test]
fn refused_or_damaged_file_leaves_the_old_program() {
    let [old, new] = files();
    let mut board = Board::with(&new);
    assert_eq!(board.download(&old), Err(Failure::Older));
    assert_eq!(board.download.operations, 0);
    let mut damaged = new.clone();
    damaged[2500] ^= 1;
    assert_eq!(board.download(&damaged), Err(Failure::Data));
    assert_eq!(board.download(&new[..2000]), Err(Failure::Length));
    assert_eq!(board.version_after_power_up(), Some(NEW));
}

#[test]
fn power_cut_at_any_operation_of_a_download_leaves_the_old_program_or_the_new_one() {
    let [old, new] = files();
    let board = Board::with(&old);
    let mut whole = board.clone();
    whole.download(&new).unwrap();
    let operations = whole.download.operations;
    assert!(operations > 1500, "{operations} operations");
    for cut in 1..=operations {
        let mut board = board.clone();
        board.download.power = Some(cut);
        let result = board.download(&new);
        let version = board.version_after_power_up();
        // Half of the bits of the commit can be sufficient.
        let is_committed = cut == operations && version == Some(NEW);
        assert!(version == Some(OLD) || is_committed, "cut at {cut}");
        assert!(result.is_err(), "cut at {cut}");
        board.download(&new).unwrap();
        assert_eq!(board.version_after_power_up(), Some(NEW), "cut at {cut}");
    }
}

#[test]
fn power_cut_at_any_operation_of_a_copy_repeats_it() {
    let [old, new] = files();
    let mut board = Board::with(&old);
    board.download(&new).unwrap();
    board.download.operations = 0;
    let mut whole = board.clone();
    whole.start().unwrap();
    let operations = whole.run.operations;
    assert!(operations > 1500, "{operations} operations");
    assert_eq!(whole.download.operations, 1, "the header becomes invalid");
    let cut = |mut board: Board, first: usize, second: Option<usize>| {
        for power in [Some(first), second].into_iter().flatten() {
            board.run.power = Some(power);
            assert_eq!(board.start(), Err(SlotError), "{first}, {second:?}");
            board.run.power = None;
        }
        assert_eq!(board.version_after_power_up(), Some(NEW));
        assert_eq!(board.run.bytes, whole.run.bytes, "{first}, {second:?}");
    };
    for first in 1..=operations {
        cut(board.clone(), first, None);
    }
    // The repair, after a cut in each kind of place: invalidation, erase, a half-word in each page, the first page, the commit.
    for first in [
        1,
        2,
        3,
        4,
        5,
        300,
        516,
        517,
        1000,
        1028,
        operations - 1,
        operations,
    ] {
        for second in (1..operations).step_by(97) {
            cut(board.clone(), first, Some(second));
        }
    }
    board.download.power = Some(1);
    assert_eq!(board.start(), Err(SlotError));
    assert_eq!(board.version_after_power_up(), Some(NEW));
}
