//! Writes the Electronic Data Sheet of the sensor into the present folder.

fn main() -> std::io::Result<()> {
    for file in descriptors::describe_all(&mast::LISTING) {
        std::fs::write(&file.name, file.text)?;
        println!("{}", file.name);
    }
    Ok(())
}
