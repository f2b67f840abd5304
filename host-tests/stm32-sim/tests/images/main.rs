//! Parts of images on the simulated chip: the memory functions, and the measurement of instruction sequences.

mod cyccnt;
mod memory_functions;
