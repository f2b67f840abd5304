//! The simulated chip against other judges: register descriptions of the makers, sampled instructions, and small programs.

mod cyccnt;
mod memory_functions;
mod registers;
mod thumb;
