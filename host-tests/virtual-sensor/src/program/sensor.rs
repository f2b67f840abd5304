//! A sensor of the command line: its product, memory, motion and firmware image.

use super::options::SensorOptions;
use super::{Failure, cannot};
use crate::server::Unit;
use bench::file::Unread;
use bench::scene::{Axes, Scene, SceneArgument};
use bench::stage::Stage;
use bench::{Bus, Device, Flash, Geometry, NodeType};
use plumbline::model::catalog::{self, PRODUCTS, Product};
use plumbline::update::PublicKey;
use std::fs::OpenOptions;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::elf::Image;

/// A sensor whose options are valid, before its bus exists.
pub(super) struct Prepared {
    pub(super) node_type: NodeType,
    serial: u32,
    image: Option<Rc<Image>>,
    /// The accelerometer of an image has no noise.
    quiet: bool,
    flash: Flash,
    stage: Stage,
}

impl Prepared {
    /// The sensor at this place of the command line.
    pub(super) fn new(
        product: &'static Product,
        options: &SensorOptions,
        place: u32,
    ) -> Result<Self, Failure> {
        let serial = options.serial.unwrap_or(place);
        let node_type = node_type(product, options)?;
        let image = image(options, node_type.name)?;
        let geometry = match &image {
            Some(image) => image.board().chip().facts().geometry,
            None => Geometry::STM32F103,
        };
        let flash = match options.store.as_deref() {
            Some(path) => open_store(geometry, path)?,
            None => Flash::blank(geometry),
        };
        let (axes, flash) = Axes::stored(&node_type, serial, flash);
        let scene = Scene::open(options.scene.as_ref(), axes)?;
        Ok(Self {
            node_type,
            serial,
            image,
            quiet: matches!(options.scene, Some(SceneArgument::Tilt(..))),
            flash,
            stage: Stage::new(scene, &options.fault),
        })
    }

    /// Attaches the sensor to the bus with this name.
    pub(super) fn attach(self, bus: &mut Bus, name: String) -> Unit {
        let (node_type, serial) = (self.node_type, self.serial);
        let motion = Box::new(self.stage.clone());
        let device = match self.image {
            Some(image) => {
                let mut microcontroller =
                    Microcontroller::of_type(&node_type, image, serial, self.flash, motion);
                if self.quiet {
                    microcontroller = microcontroller.quiet();
                }
                microcontroller.report_stop();
                bus.attach(microcontroller)
            }
            None => bus.attach(Device::new(&node_type, serial, self.flash, motion)),
        };
        Unit::new(name, device, node_type, serial, self.stage)
    }
}

/// The type of the sensor of the options.
fn node_type(product: &'static Product, options: &SensorOptions) -> Result<NodeType, Failure> {
    let node_type = NodeType::from(product);
    let Some(wanted) = &options.article else {
        return Ok(node_type);
    };
    if options.elf.is_some() || options.bootloader.is_some() {
        let message = "the article is in the firmware image: omit --article or --elf";
        return Err(Failure::Usage(message.to_owned()));
    }
    node_type.with_article(wanted).ok_or_else(|| {
        let articles: Vec<String> = product
            .articles()
            .map(|article| format!("{} ({})", article.name, article.number))
            .collect();
        let own = articles.join(", ");
        let others = PRODUCTS.iter().filter(|other| has_article(other, wanted));
        let others: Vec<&str> = others.map(|other| other.name).collect();
        let hint = match &others[..] {
            [] => String::new(),
            others => format!("; {wanted} is an article of {}", others.join(", ")),
        };
        let model = product.name;
        Failure::Usage(format!(
            "{model} has no article {wanted}; its articles are {own}{hint}"
        ))
    })
}

fn has_article(product: &Product, wanted: &str) -> bool {
    product.articles().any(|article| article.is(wanted))
}

/// The memory in `path`, which is created if it does not exist. If it cannot be written, the memory reports this from the start, and
/// the sensor continues with its contents.
fn open_store(geometry: Geometry, path: &Path) -> Result<Flash, Failure> {
    let unusable = |error| cannot(format!("use the store {}", path.display()))(error);
    // The opening of a pipe would wait without end.
    match bench::file::open(path) {
        Err(why @ Unread::Unfit(_)) => return Err(unusable(why.into())),
        Err(Unread::Failed(_)) | Ok(_) => {}
    }
    let writable = OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(false)
        .open(path);
    let problem = match (Flash::in_file(geometry, path), writable) {
        (Ok(flash), Ok(_)) => return Ok(flash),
        (Err(error), _) if error.kind() == ErrorKind::ResourceBusy => {
            return Err(unusable(error));
        }
        (Err(error), _) | (Ok(_), Err(error)) => error,
    };
    let path_shown = path.display();
    let why = format!("cannot use the store {path_shown}: {problem}; nothing can be saved");
    Ok(Flash::unusable(geometry, path, why))
}

/// The length of the longest ELF file in bytes.
const LONGEST_ELF: u64 = 1 << 28;

/// The firmware image of the options, with its bootloader; None: the model for the PC.
fn image(options: &SensorOptions, model: &str) -> Result<Option<Rc<Image>>, Failure> {
    let open = |path: &Option<PathBuf>| {
        let path = path.as_deref();
        path.map(|path| open_image(path, model)).transpose()
    };
    let (image, bootloader) = (open(&options.elf)?, open(&options.bootloader)?);
    let bootloader = match (bootloader, &options.key) {
        (Some(bootloader), Some(path)) => {
            let message = "the bootloader does not check signatures, so it has no place for a key: build it with --features signature";
            let with_key = bootloader.with_key(&key(path)?);
            Some(with_key.ok_or_else(|| Failure::Usage(message.to_owned()))?)
        }
        (bootloader, _) => bootloader,
    };
    let image = match (image, bootloader) {
        (Some(image), None) if image.needs_bootloader() => {
            let message = "the image is built for a flash with a bootloader: add --bootloader FILE";
            return Err(Failure::Usage(message.to_owned()));
        }
        (Some(image), Some(bootloader)) => {
            let both = image.behind(&bootloader);
            let message = "the two images do not fit: build that of --elf with --features behind-bootloader, for the board of the bootloader";
            Some(both.ok_or_else(|| Failure::Usage(message.to_owned()))?)
        }
        (None, Some(bootloader)) => Some(bootloader.as_bootloader()),
        (image, None) => image,
    };
    Ok(image.map(Rc::new))
}

/// The public key in a file.
fn key(path: &Path) -> Result<PublicKey, Failure> {
    let what = format!("read the public key {}", path.display());
    let bytes = bench::file::read(path, LONGEST_ELF).map_err(|why| cannot(what)(why.into()))?;
    let bytes = bytes.try_into().map_err(|_| {
        let (path, size) = (path.display(), PublicKey::SIZE);
        Failure::Usage(format!(
            "{path} is not a public key of {size} bytes: `plumbline key show FILE -o key.bin` writes one"
        ))
    });
    bytes.map(PublicKey::from_bytes)
}

/// The firmware image in an ELF file; checks the model, if the file has symbols.
fn open_image(path: &Path, model: &str) -> Result<Image, Failure> {
    let what = format!("read the firmware image {}", path.display());
    let elf = bench::file::read(path, LONGEST_ELF).map_err(|why| cannot(&what)(why.into()))?;
    let image =
        Image::parse(&elf).map_err(|error| Failure::Outside(format!("cannot {what}: {error}")))?;
    let other = image.program().filter(|program| *program != model);
    if let Some(other) = other.filter(|program| catalog::find(program).is_some()) {
        return Err(Failure::Usage(format!(
            "{} is an image of the model {other}, not of {model}",
            path.display(),
        )));
    }
    Ok(image)
}
