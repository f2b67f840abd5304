//! The simulated chip against other judges: register descriptions of the makers, and sampled instructions.

mod registers;
mod thumb;
