use super::*;
use std::io::Read;

const LIMIT: u64 = 1 << 20;

fn numbers(queue: &mut Queue, cursor: &mut Cursor) -> Vec<u64> {
    let records = queue.read(cursor, usize::MAX).unwrap();
    for (number, bytes) in &records {
        assert_eq!(bytes, &number.to_string().into_bytes());
    }
    records.into_iter().map(|(number, _)| number).collect()
}

fn push(queue: &mut Queue, count: u64) {
    for _ in 0..count {
        let text = queue.next().to_string();
        queue.push(text.as_bytes()).unwrap();
    }
}

#[test]
fn records_that_are_not_acknowledged_are_there_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
    push(&mut queue, 10);
    assert_eq!(
        numbers(&mut queue, &mut Cursor::default()),
        (1..=10).collect::<Vec<_>>()
    );
    queue.acknowledge(4);
    queue.sync().unwrap();
    drop(queue);
    let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
    let mut cursor = Cursor::default();
    assert_eq!(
        numbers(&mut queue, &mut cursor),
        (4..=10).collect::<Vec<_>>()
    );
    push(&mut queue, 2);
    assert_eq!(numbers(&mut queue, &mut cursor), [11, 12]);
    assert_eq!(queue.waiting(), 9);
}

#[test]
fn numbers_go_on_after_all_files_are_deleted() {
    let folder = tempfile::tempdir().unwrap();
    for start in [1, 6, 11] {
        let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
        assert_eq!((queue.next(), queue.waiting()), (start, 0));
        push(&mut queue, 5);
        queue.acknowledge(start + 5);
        queue.sync().unwrap();
    }
    drop(Queue::open(folder.path(), LIMIT).unwrap());
    let files = fs::read_dir(folder.path()).unwrap();
    let records = files.filter(|file| {
        let path = file.as_ref().unwrap().path();
        path.extension().is_some_and(|own| own == EXTENSION)
    });
    assert_eq!(records.count(), 0);
}

#[test]
fn numbers_that_a_power_cut_can_have_lost_are_not_used_again() {
    for (last, first) in [(ENDED, 6), ("", 6), ("another start", 6 + LEFT_OUT)] {
        let folder = tempfile::tempdir().unwrap();
        let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
        push(&mut queue, 5);
        queue.sync().unwrap();
        drop(queue);
        fs::write(folder.path().join("lock"), last).unwrap();
        // A start that finds no sensor adds no record.
        drop(Queue::open(folder.path(), LIMIT).unwrap());
        let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
        assert_eq!((queue.next(), queue.waiting()), (first, 5), "{last}");
        push(&mut queue, 1);
        let all = numbers(&mut queue, &mut Cursor::default());
        assert_eq!(all, [1, 2, 3, 4, 5, first], "{last}");
    }
}

#[test]
fn damaged_end_of_file_loses_only_its_records() {
    for (damage, last) in [("cut", 6), ("bit", 6), ("zeros", 7)] {
        let folder = tempfile::tempdir().unwrap();
        let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
        push(&mut queue, 5);
        let path = queue.path(1);
        drop(queue);
        let mut bytes = Vec::new();
        File::open(&path).unwrap().read_to_end(&mut bytes).unwrap();
        match damage {
            "cut" => bytes.truncate(bytes.len() - 1),
            "zeros" => bytes.extend([0; 64]),
            _ => *bytes.last_mut().unwrap() ^= 1,
        }
        fs::write(&path, bytes).unwrap();
        let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
        push(&mut queue, 2);
        let all = numbers(&mut queue, &mut Cursor::default());
        assert_eq!(all, (1..=last).collect::<Vec<_>>(), "{damage}");
    }
}

#[test]
fn oldest_records_are_lost_at_the_limit_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let limit = 4096;
    let mut queue = Queue::open(folder.path(), limit).unwrap();
    let mut cursor = Cursor::default();
    push(&mut queue, 1000);
    let lost = queue.take_lost();
    let left = numbers(&mut queue, &mut cursor);
    assert_eq!(left, (lost + 1..=1000).collect::<Vec<_>>());
    assert!(queue.length() <= limit && lost > 0, "{lost}");
    assert_eq!(queue.take_lost(), 0);
}

#[test]
fn folder_has_one_user() {
    let folder = tempfile::tempdir().unwrap();
    let queue = Queue::open(folder.path(), LIMIT).unwrap();
    let second = Queue::open(folder.path(), LIMIT).map(|_| ());
    assert_eq!(second.unwrap_err().code(), "buffer-in-use");
    drop(queue);
    Queue::open(folder.path(), LIMIT).unwrap();
}
