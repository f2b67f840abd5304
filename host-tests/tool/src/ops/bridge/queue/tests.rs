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
    for (damage, whole) in [("cut", 4), ("bit", 4), ("zeros", 5)] {
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
        // The broker can have the records behind the damage.
        let new = whole + 1 + LEFT_OUT;
        let expected: Vec<u64> = (1..=whole).chain(new..new + 2).collect();
        assert_eq!(all, expected, "{damage}");
        assert!(queue.take_lost().is_damaged, "{damage}");
    }
}

#[test]
fn damaged_record_in_the_file_that_is_written_loses_only_the_rest_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
    push(&mut queue, 5);
    let mut bytes = fs::read(queue.path(1)).unwrap();
    // Each record has 8 bytes before its text of one digit.
    bytes[3 * 9] ^= 1;
    fs::write(queue.path(1), bytes).unwrap();
    let mut cursor = Cursor::default();
    assert_eq!(numbers(&mut queue, &mut cursor), [1, 2, 3]);
    assert!(queue.take_lost().is_damaged);
    push(&mut queue, 2);
    assert_eq!(numbers(&mut queue, &mut cursor), [6, 7]);
    // Another connection begins with what is not acknowledged.
    queue.acknowledge(4);
    assert_eq!(numbers(&mut queue, &mut Cursor::default()), [6, 7]);
    assert_eq!((queue.waiting(), queue.take_lost()), (2, Lost::default()));
}

#[cfg(unix)]
#[test]
fn deleted_file_that_is_written_loses_only_its_records() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
    push(&mut queue, 3);
    fs::remove_file(queue.path(1)).unwrap();
    let mut cursor = Cursor::default();
    assert!(numbers(&mut queue, &mut cursor).is_empty());
    assert!(queue.take_lost().is_damaged);
    push(&mut queue, 2);
    assert_eq!(numbers(&mut queue, &mut cursor), [4, 5]);
    assert_eq!(queue.waiting(), 2);
}

#[cfg(target_os = "linux")]
#[test]
fn records_on_a_full_disk_are_lost_and_counted_until_there_is_space() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
    // The disk is full for two files: the first of all, and one behind others.
    let full = |queue: &Queue| {
        std::os::unix::fs::symlink("/dev/full", queue.path(queue.next())).unwrap();
    };
    let mut cursor = Cursor::default();
    full(&queue);
    push(&mut queue, 3);
    let lost = |count| Lost {
        disk: count,
        ..Lost::default()
    };
    assert_eq!(queue.take_lost(), lost(1));
    assert_eq!(numbers(&mut queue, &mut cursor), [2, 3]);
    queue.complete();
    full(&queue);
    queue.acknowledge(4);
    push(&mut queue, 2);
    // The file before makes room; it is acknowledged, so only the new record is lost.
    assert_eq!(queue.take_lost(), lost(1));
    assert_eq!(numbers(&mut queue, &mut cursor), [5]);
    queue.acknowledge(6);
    queue.sync().unwrap();
    assert_eq!((queue.waiting(), queue.next()), (0, 6));
    drop(queue);
    assert_eq!(Queue::open(folder.path(), LIMIT).unwrap().next(), 6);
}

#[test]
fn records_that_come_while_others_are_brought_to_the_disk_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
    push(&mut queue, 3);
    queue.acknowledge(4);
    let unsynced = queue.unsynced().unwrap();
    push(&mut queue, 2);
    queue.acknowledge(5);
    unsynced.write().unwrap();
    queue.synced(&unsynced);
    drop(queue);
    let mut queue = Queue::open(folder.path(), LIMIT).unwrap();
    assert_eq!(numbers(&mut queue, &mut Cursor::default()), [4, 5]);
}

#[test]
fn oldest_records_are_lost_at_the_limit_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let limit = 4096;
    let mut queue = Queue::open(folder.path(), limit).unwrap();
    let mut cursor = Cursor::default();
    push(&mut queue, 1000);
    let lost = queue.take_lost().limit;
    let left = numbers(&mut queue, &mut cursor);
    assert_eq!(left, (lost + 1..=1000).collect::<Vec<_>>());
    assert!(queue.length() <= limit && lost > 0, "{lost}");
    assert_eq!(queue.take_lost(), Lost::default());
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
