//! The documents of the products: the Markdown files beside the models.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A Markdown file beside a model.
pub struct Document {
    /// The path of the file.
    pub path: PathBuf,
    /// The text of the file.
    pub text: String,
}

/// All documents, sorted by path.
///
/// # Errors
/// A file or a folder cannot be read.
pub fn documents() -> io::Result<Vec<Document>> {
    let mut documents = Vec::new();
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src/model");
    collect(&models, &mut documents)?;
    documents.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(documents)
}

/// Adds the Markdown files in a folder and in the folders below it.
fn collect(folder: &Path, documents: &mut Vec<Document>) -> io::Result<()> {
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, documents)?;
        } else if path.extension().is_some_and(|extension| extension == "md") {
            let text = fs::read_to_string(&path)?;
            documents.push(Document { path, text });
        }
    }
    Ok(())
}
