//! The second task: a pole on a cart, which falls unless the cart is pushed well.
//!
//! [`dynamics`] is gymnasium's `CartPole-v1` with CARL's context, [`environment`] its episodes and
//! [`family`] the family of 576 point MDPs of the paper. [`ppo`] and [`dqn`] are the methods with their
//! settings; [`domain`], [`problem`] and [`trial`] are what evaluation sees.

pub mod domain;
pub mod dqn;
pub mod dynamics;
pub mod environment;
pub mod family;
pub mod load;
pub mod ppo;
pub mod problem;
pub mod settings;
pub mod trial;
