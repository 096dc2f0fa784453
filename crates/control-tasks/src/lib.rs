//! Families of control tasks: gymnasium's cart and pole so far.

pub mod cartpole;
