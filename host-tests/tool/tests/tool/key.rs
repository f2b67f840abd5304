//! `plumbline key`: the private key of image files.

use crate::process::sensor::{document, plumbline};
use hbs_lms::signature::SignerMut;
use hbs_lms::{HssParameter, LmotsAlgorithm, LmsAlgorithm, Seed, Sha256_256};
use plumbline::update::header::{SIZE, body_parts};
use plumbline::update::lms::{Lms, Signature, sha256};
use plumbline::update::{Contents, Element, Header, PublicKey};
use plumbline_tool::signing::PrivateKey;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

/// A folder of a test with an image file of an is2.
struct Files {
    folder: PathBuf,
}

impl Files {
    fn new(test: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("key-{test}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let files = Self { folder };
        let body: Vec<u8> = (0..2048_u32).map(|place| place as u8).collect();
        let contents = Contents {
            product: plumbline::model::catalog::find("is2")
                .unwrap()
                .image
                .number(),
            element: Element::Ism330dhcx,
            board: 1,
            layout: 1,
            key: 0,
            version: 0x0001_0203,
            hash: [0; 32],
        };
        let header = Header::new(&contents, &body).unwrap();
        fs::write(files.path("is2.plu"), [header.bytes(), &body[..]].concat()).unwrap();
        files
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    /// The command line that signs the image file.
    fn sign(&self, output: &str) -> String {
        let [image, key, output] = ["is2.plu", "own.key", output].map(|name| self.text(name));
        format!("--json key sign {image} --key {key} -o {output}")
    }

    fn new_key(&self) {
        document(&plumbline(
            "",
            &format!("--json key new {}", self.text("own.key")),
        ));
    }

    /// The leaf that has signed a file, its header and its signature.
    fn signed(&self, name: &str) -> (u32, Vec<u8>, Vec<u8>) {
        let file = fs::read(self.path(name)).unwrap();
        let signature = file[SIZE..][..Signature::SIGNATURE].to_vec();
        let leaf = u32::from_be_bytes(*signature.first_chunk().unwrap());
        (leaf, file[..SIZE].to_vec(), signature)
    }
}

#[track_caller]
fn is_refused(line: &str, reason: &str) {
    let output = plumbline("", line);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(text.contains(reason), "{text}");
}

#[test]
fn signature_of_the_header_is_correct_here_and_in_another_implementation() {
    let files = Files::new("correct");
    files.new_key();
    let told = document(&plumbline("", &files.sign("signed.plu")));
    assert_eq!(told["left"], 1023);
    let public = files.text("key.bin");
    let show = format!("--json key show {} -o {public}", files.text("own.key"));
    let shown = document(&plumbline("", &show));
    assert_eq!(
        (&shown["left"], &shown["key"]),
        (&told["left"], &told["key"])
    );
    let public = fs::read(public).unwrap();
    let key = PublicKey::from_bytes(public[..].try_into().unwrap());
    let (_, header, signature) = files.signed("signed.plu");
    assert!(key.verifies(&header, &signature));
    let parsed = Header::parse(header[..].try_into().unwrap()).unwrap();
    assert_eq!(parsed.key(), key.number());
    let body = fs::read(files.path("is2.plu")).unwrap()[SIZE..].to_vec();
    assert_eq!(header[24..56], sha256(&body_parts(&body)));
    // HSS with one level: the number of levels is before the key, and that of signed keys before the signature.
    let verify = |message: &[u8]| {
        let (key, signature) = (
            [&[0, 0, 0, 1], &public[..]].concat(),
            [&[0; 4], &signature[..]].concat(),
        );
        hbs_lms::verify::<Sha256_256>(message, &signature, &key)
    };
    assert!(verify(&header).is_ok());
    assert!(verify(&header[1..]).is_err());
    // A signed file can be signed again.
    let again = files.sign("again.plu").replace("is2.plu", "signed.plu");
    document(&plumbline("", &again));
    let (leaf, header, signature) = files.signed("again.plu");
    assert!(leaf == 1 && key.verifies(&header, &signature));
}

#[test]
fn signature_of_another_implementation_is_correct() {
    let parameters = [HssParameter::new(
        LmotsAlgorithm::LmotsW4,
        LmsAlgorithm::LmsH5,
    )];
    let mut seed = Seed::default();
    seed.as_mut_slice().fill(0x42);
    let (mut private, public) =
        hbs_lms::keygen::<Sha256_256>(&parameters, &seed, None).expect("a key");
    let public = &public.as_slice()[4..];
    for message in [&b"first"[..], b"second"] {
        let signature = private.try_sign(message).expect("a signature");
        let signature = &signature.as_ref()[4..];
        let id = public[8..].first_chunk().unwrap();
        let root = Lms::<5, 4>::root(id, message, signature).expect("a signature");
        assert_eq!(public[24..], root);
        assert_ne!(Lms::<5, 4>::root(id, b"third", signature), Some(root));
    }
}

#[test]
fn processes_at_the_same_time_use_different_leaves() {
    let files = Files::new("parallel");
    files.new_key();
    let names = ["a.plu", "b.plu", "c.plu", "d.plu"];
    thread::scope(|scope| {
        for name in names {
            scope.spawn(|| document(&plumbline("", &files.sign(name))));
        }
    });
    let leaves: BTreeSet<u32> = names.iter().map(|name| files.signed(name).0).collect();
    assert_eq!(leaves, BTreeSet::from([0, 1, 2, 3]));
    let text = fs::read_to_string(files.path("own.key")).unwrap();
    let (_, lines) = text.split_once("signatures:\n").unwrap();
    let expected = (0..4).map(|leaf| format!("{leaf} is2 1.2.3 for bluepill\n"));
    assert_eq!(lines, expected.collect::<String>());
}

#[test]
fn interrupted_line_counts_as_a_used_leaf_and_a_used_up_key_says_so() {
    let files = Files::new("used");
    files.new_key();
    let path = files.path("own.key");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{text}0 is2 1.0.0 for bluepill\n1 is")).unwrap();
    document(&plumbline("", &files.sign("third.plu")));
    assert_eq!(files.signed("third.plu").0, 2);
    let all: String = (0..1023).map(|leaf| format!("{leaf} is2\n")).collect();
    fs::write(&path, format!("{text}{all}")).unwrap();
    let told = document(&plumbline("", &files.sign("last.plu")));
    assert_eq!(told["left"], 0);
    assert_eq!(files.signed("last.plu").0, 1023);
    is_refused(&files.sign("more.plu"), "key-used-up");
    assert!(!files.path("more.plu").exists());
}

#[test]
fn file_that_is_no_key_is_refused_and_a_key_is_never_replaced() {
    let files = Files::new("wrong");
    files.new_key();
    let path = files.path("own.key");
    let text = fs::read_to_string(&path).unwrap();
    is_refused(
        &format!("--json --yes=overwrite key new {}", files.text("own.key")),
        "file-exists",
    );
    assert_eq!(fs::read_to_string(&path).unwrap(), text);
    let seed = text.find("seed ").unwrap() + 5;
    let mut other = text.clone();
    let digit = if other.as_bytes()[seed] == b'0' {
        "1"
    } else {
        "0"
    };
    other.replace_range(seed..=seed, digit);
    for (wrong, reason) in [
        ("", "it is no private key"),
        ("no key\n", "it is no private key"),
        (
            text.trim_end_matches("signatures:\n"),
            "it is no private key",
        ),
        (&other, "do not belong together"),
    ] {
        fs::write(&path, wrong).unwrap();
        is_refused(&files.sign("signed.plu"), reason);
        assert_eq!(fs::read_to_string(&path).unwrap(), wrong, "nothing is used");
        assert!(!files.path("signed.plu").exists());
    }
}

#[test]
fn key_depends_on_identifier_and_seed() {
    let key = PrivateKey::new([1; 16], [2; 32]).public();
    assert_eq!(key.number(), 0x0101);
    assert_ne!(PrivateKey::new([1; 16], [3; 32]).public(), key);
}
