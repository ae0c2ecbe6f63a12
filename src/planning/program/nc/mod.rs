//! NC programs (RS-274).

pub mod emit;
pub mod read;
