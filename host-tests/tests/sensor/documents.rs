//! The documents of the products contain the tables of the products, and the README lists their articles. The document of a product
//! that differs from an earlier one by constants only is the one of its file.
//!
//! A document of a product is a Markdown file beside its model. It has the table of the product in a block:
//!
//! ```text
//! <!-- parameters of is2, is2d: written from the product's table, checked by host-tests/tests/sensor/documents.rs -->
//! | read | write | ...
//! <!-- end -->
//! ```
//!
//! A block can belong to several products with equal tables. `UPDATE=1 cargo test -p host-tests --test sensor documents`
//! writes the blocks.

use descriptors::{Table, table};
use host_tests::documents::{Document, documents};
use plumbline::model::catalog::{PRODUCTS, Product, bases, find};
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

const README: &str = include_str!("../../../README.md");

/// Maximum length of the README.
const README_LINES: usize = 250;

/// The start of a block.
const BEGIN: &str = "<!-- ";
/// The end of the heading of a block.
const ORIGIN: &str =
    ": written from the product's table, checked by host-tests/tests/sensor/documents.rs -->\n";
/// The end of a block.
const END: &str = "<!-- end -->\n";

/// The table of some products in a document.
struct Block<'a> {
    title: &'a str,
    products: Vec<&'a str>,
    table: &'a str,
}

/// All documents. Their blocks are written again if UPDATE is set.
static DOCUMENTS: LazyLock<Vec<Document>> = LazyLock::new(|| {
    let mut documents = documents().expect("the documents can be read");
    if std::env::var_os("UPDATE").is_some() {
        for document in &mut documents {
            document.text = updated(&document.text);
            std::fs::write(&document.path, &document.text).expect("the document can be written");
        }
    }
    documents
});

/// The part of a text before a block, the block, and the rest; None if there is no further block.
fn next_block(text: &str) -> Option<(&str, Block<'_>, &str)> {
    let (before, after) = text.split_once(ORIGIN)?;
    let (before, heading) = before
        .rsplit_once(BEGIN)
        .expect("the heading of a block is a comment");
    let (title, products) = heading
        .split_once(" of ")
        .unwrap_or_else(|| panic!("a heading is `<title> of <products>`: {heading}"));
    let (table, rest) = after
        .split_once(END)
        .unwrap_or_else(|| panic!("the block has no end: {heading}"));
    let products = products.split(", ").collect();
    let block = Block {
        title,
        products,
        table,
    };
    Some((before, block, rest))
}

/// All blocks of a document.
fn blocks(mut text: &str) -> Vec<Block<'_>> {
    std::iter::from_fn(|| {
        let (_, block, rest) = next_block(text)?;
        text = rest;
        Some(block)
    })
    .collect()
}

/// The text of a document with its blocks written from the tables of the products.
fn updated(mut text: &str) -> String {
    let mut written = String::new();
    while let Some((before, block, rest)) = next_block(text) {
        let table = table(product(block.products[0]));
        let heading = heading(&table, &block.products);
        written += &format!("{before}{heading}{}{END}", table.text);
        text = rest;
    }
    written + text
}

fn heading(table: &Table, products: &[&str]) -> String {
    format!("{BEGIN}{} of {}{ORIGIN}", table.title, products.join(", "))
}

#[track_caller]
fn product(name: &str) -> &'static Product {
    find(name).unwrap_or_else(|| panic!("a block names {name}, which is no product"))
}

/// The documents with a block of this product.
fn documents_of(name: &str) -> Vec<&'static Document> {
    let names = |document: &&Document| {
        blocks(&document.text)
            .iter()
            .any(|block| block.products.contains(&name))
    };
    DOCUMENTS.iter().filter(names).collect()
}

#[test]
fn every_product_has_its_table_in_exactly_one_document() {
    for product in bases() {
        let documents = documents_of(product.name);
        assert_eq!(
            documents.len(),
            1,
            "one Markdown file beside the models should have this block:\n\n{}{END}",
            heading(&table(product), &[product.name])
        );
    }
}

#[test]
fn every_block_equals_the_table_of_its_products() {
    for document in &*DOCUMENTS {
        for block in blocks(&document.text) {
            for name in &block.products {
                let table = table(product(name));
                assert!(
                    block.title == table.title && block.table == table.text,
                    "{} should have this block (UPDATE=1 writes it):\n\n{}{}{END}",
                    document.path.display(),
                    heading(&table, &[name]),
                    table.text
                );
            }
        }
    }
}

#[test]
fn every_article_is_listed_in_the_document_of_its_product() {
    for product in PRODUCTS {
        for document in documents_of(product.name) {
            for article in product.articles() {
                let row = format!(
                    "| `{}` | {} | {} |",
                    product.name, article.name, article.number
                );
                assert!(
                    document.text.contains(&row),
                    "{} should have a row that begins with\n{row}",
                    document.path.display()
                );
            }
        }
    }
}

#[test]
fn readme_lists_products_with_all_their_articles() {
    let rows = README.lines().filter(|line| line.starts_with("| `"));
    let listed = rows.filter_map(|row| Some((row, find(row.split('`').nth(1)?)?)));
    let listed: Vec<_> = listed.collect();
    assert!(
        !listed.is_empty(),
        "the README has no table of the products"
    );
    for (row, product) in listed {
        for article in product.articles() {
            let (name, article) = (product.name, article.name);
            assert!(row.contains(article), "{name} without {article}");
        }
    }
}

#[test]
fn readme_links_point_to_existing_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for part in README.split("](").skip(1) {
        let (link, _) = part.split_once(')').expect("the end of the link");
        if link.starts_with("https://") {
            continue;
        }
        let (file, section) = link.split_once('#').unwrap_or((link, ""));
        assert!(root.join(file).exists(), "there is no {file}");
        assert!(
            section.is_empty() || sections(&root.join(file)).contains(&section.to_owned()),
            "there is no {link}"
        );
    }
}

/// The names of the sections of a Markdown file, as links have them.
fn sections(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).expect("a document");
    let titles = text.lines().filter(|line| line.starts_with("##"));
    let name = |title: &str| title.trim_start_matches(['#', ' ']).to_lowercase();
    titles.map(|title| name(title).replace(' ', "-")).collect()
}

#[test]
fn readme_does_not_exceed_250_lines() {
    let lines = README.lines().count();
    assert!(lines <= README_LINES, "{lines} lines");
}

/// `cargo run --bin error-budget` prints them.
#[test]
fn page_of_the_elements_has_the_error_budget() {
    let page = include_str!("../../../firmware-stm32/ELEMENTS.md");
    let tables = host_tests::error_budget::tables();
    assert!(page.contains(&tables), "the page must have:\n{tables}");
}
