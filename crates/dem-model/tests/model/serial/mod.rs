//! Serial arms of any axes.

mod consistency;
mod integration;
mod random_arm;
mod vectors;
