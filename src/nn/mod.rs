//! Small neural networks on one thread: what the learners need and nothing else.

pub mod archive;
