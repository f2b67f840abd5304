//! What the model built for the PC and an image have in common. The test `images` has the same modules with images.

mod control;
mod fault;
mod opening;
